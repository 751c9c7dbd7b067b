#pragma once

#include "tests/mock_printer/dialect.h"
#include "tests/mock_printer/fault_script.h"
#include "tests/mock_printer/motion_settings.h"
#include "tests/mock_printer/thermal.h"

#include <array>
#include <string>

namespace voidpath::test::mock {

/// The printer to be built. Times in s on the printer's clock.
struct Options {
  Dialect dialect = *find_dialect("marlin2");
  MotionSettings motion;
  std::size_t block_buffer = 16;  ///< ring; holds one less
  std::size_t rx_buffer = 128;    ///< ring; holds one less
  std::size_t queue = 4;          ///< commands, the executing one included
  double baud = 0;                ///< 0: the wire costs no time
  double round_trip_s = 0;        ///< half of it each way
  double boot_s = 0;              ///< what arrives meanwhile is lost
  bool advanced_ok = false;
  bool emergency_parser = false;  ///< M108, M112, M410 act as they arrive
  bool meatpack = false;          ///< offers and understands it
  bool instant_moves = false;     ///< no planner: a move is over as soon as it is read
  bool parenthesis_comments = false;
  bool cold_extrusion = false;  ///< extrude at any temperature
  double min_extrusion_temperature = 170;
  double max_extrusion_mm = 200;                   ///< longer ones in one move are prevented
  std::array<double, 3> volume_mm{220, 220, 250};  ///< X, Y, Z as M211 tells it; nobody enforces it
  double reach_mm = 1000;  ///< X, Y and Z are held within this distance of 0, as by soft endstops
  double busy_interval_s = 2;
  double leveling_s = 30;  ///< G29
  double tuning_s = 600;   ///< M303
  int pause_waits = 1;     ///< so often M600 waits: to load, to heat again, to purge
  double homing_speed_mm_s = 50;
  HeaterModel hotend{};
  HeaterModel bed{25, 125, 250, 120};
  std::vector<Fault> faults;
  std::uint64_t seed = 1;
};

/// Spells a printer out: make_mock().baud(115200).lose_ok(40).build().
class OptionsBuilder {
 public:
  OptionsBuilder& firmware(const std::string& name) {
    return set(&Options::dialect, find_dialect(name).value());
  }
  OptionsBuilder& motion(const MotionSettings& m) { return set(&Options::motion, m); }
  OptionsBuilder& baud(double b) { return set(&Options::baud, b); }
  OptionsBuilder& round_trip(double s) { return set(&Options::round_trip_s, s); }
  OptionsBuilder& rx_buffer(std::size_t n) { return set(&Options::rx_buffer, n); }
  OptionsBuilder& queue(std::size_t n) { return set(&Options::queue, n); }
  OptionsBuilder& boot(double s) { return set(&Options::boot_s, s); }
  OptionsBuilder& advanced_ok(bool on = true) { return set(&Options::advanced_ok, on); }
  OptionsBuilder& emergency_parser(bool on = true) { return set(&Options::emergency_parser, on); }
  OptionsBuilder& meatpack(bool on = true) { return set(&Options::meatpack, on); }
  OptionsBuilder& instant_moves(bool on = true) { return set(&Options::instant_moves, on); }
  OptionsBuilder& cold_extrusion(bool on = true) { return set(&Options::cold_extrusion, on); }
  OptionsBuilder& seed(std::uint64_t s) { return set(&Options::seed, s); }
  OptionsBuilder& fault(const Fault& fault) {
    options_.faults.push_back(fault);
    return *this;
  }
  /// The n-th (from 1) byte, line or ok, by the kind's nature.
  OptionsBuilder& fault(FaultKind kind, double at) {
    Fault f;
    f.kind = kind;
    f.trigger = natural_trigger(kind);
    f.at = at;
    return fault(f);
  }
  /// By chance at each byte, line or ok.
  OptionsBuilder& noise(FaultKind kind, double probability, bool outwards = false) {
    Fault f;
    f.kind = kind;
    f.trigger = natural_trigger(kind);
    f.probability = probability;
    f.outwards = outwards;
    return fault(f);
  }
  OptionsBuilder& lose_ok(double n) { return fault(FaultKind::kLoseOk, n); }
  Options build() const { return options_; }

 private:
  template <class T>
  OptionsBuilder& set(T Options::*member, T value) {
    options_.*member = std::move(value);
    return *this;
  }
  Options options_;
};

inline OptionsBuilder make_mock() { return {}; }

}  // namespace voidpath::test::mock
