#pragma once

#include "tests/mock_printer/thermal.h"

#include <optional>
#include <string>

/// Hotend and bed with the firmware's guards over them, on the printer's clock (s, °C).
namespace voidpath::test::mock {

/// When a heater is taken to have failed.
struct HeaterGuard {
  double watch_s;      ///< while heating up: so long...
  double watch_gain;   ///< ...for so many degrees
  double runaway_s;    ///< at the target: so long...
  double runaway_gap;  ///< ...further below it than this
};

/// One heater under guard.
class GuardedHeater {
 public:
  GuardedHeater(std::string id, const HeaterModel& model, const HeaterGuard& guard)
      : id_(std::move(id)), heater_(model), guard_(guard) {}

  Heater& heater() { return heater_; }
  const Heater& heater() const { return heater_; }
  void set_target(double now, double target);
  /// The fault found at `now`, e.g. "Heating failed". To be asked once a second.
  std::optional<std::string> check(double now);
  /// Heater_ID in messages: E0, bed.
  const std::string& id() const { return id_; }

 private:
  std::string id_;
  Heater heater_;
  HeaterGuard guard_;
  bool reached_ = false;
  double watch_start_ = 0, watch_goal_ = 0;
  double below_since_ = -1;
};

/// Waiting for a temperature (M109, M190): within the window for the residency time.
class HeatWait {
 public:
  HeatWait(bool bed, bool also_cooling) : bed_(bed), also_cooling_(also_cooling) {}
  bool bed() const { return bed_; }
  /// Asked at each report (once a second) and at `done_at`: whether the wait is over.
  bool over(double now, const Heater& heater);
  /// ` W:?` or ` W:3`.
  std::string countdown(double now) const;
  double done_at() const;

 private:
  bool bed_, also_cooling_;
  double resident_since_ = -1;
};

}  // namespace voidpath::test::mock
