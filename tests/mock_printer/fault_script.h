#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

/// What goes wrong, when, and how often.
namespace voidpath::test::mock {

enum class FaultKind {
  // bytes, on their way in (host to printer) or out
  kDropByte,
  kFlipByte,
  kDoubleByte,
  kInsertByte,
  // lines the printer has read, before it checks them
  kDropLine,
  kGarbleLine,
  kDoubleLine,
  // acknowledgements
  kLoseOk,
  kDoubleOk,
  kGarbleOk,
  kResendWithoutOk,  ///< a resend request that was due goes out without its ok
  kSpuriousResend,   ///< a good line is refused
  // the printer itself
  kReset,
  kHalt,        ///< `text`: what the firmware dies of, e.g. "Thermal Runaway"
  kUnplug,      ///< the cable is out for `seconds`
  kSilence,     ///< reads and says nothing for `seconds`; what moves keeps moving
  kSlow,        ///< each of the next `lines` commands takes `seconds` longer
  kDeadHeater,  ///< `heater` (hotend, bed) stops heating
  kCancel,      ///< S3G: cancelled at the panel
  kBusy,        ///< S3G: a print from the card for `seconds`
  kPause,       ///< the printer pauses by itself (filament runout) until M108 or M876
};

enum class FaultTrigger { kByte, kLine, kOk, kTime };

struct Fault {
  FaultKind kind{};
  bool outwards = false;  ///< bytes: printer to host
  /// The n-th byte, line or ok (from 1) or the time in s on the printer's clock...
  std::optional<double> at;
  FaultTrigger trigger = FaultTrigger::kLine;
  /// ...or by chance at each byte, line or ok.
  double probability = 0;
  std::uint64_t limit = 0;  ///< fires at most so often; 0: once when `at` is given, else without limit
  double seconds = 1;
  std::uint64_t lines = 1;
  std::string text = "Thermal Runaway";
  std::string heater = "hotend";
  std::uint64_t fired = 0;
};

/// Reads a script. Throws std::runtime_error with the line of the first mistake. Form:
///   faults:
///     - {kind: flip_byte, direction: in, probability: 1e-4}
///     - {kind: lose_ok, ok: 40}
///     - {kind: reset, line: 1200}
///     - {kind: halt, time: 30, text: Heating failed, heater: hotend}
std::vector<Fault> parse_faults(const std::string& yaml);
std::vector<Fault> load_faults(const std::string& path);

/// The trigger a kind has when only a probability is given.
FaultTrigger natural_trigger(FaultKind kind);

/// Decides, deterministically for a seed, which faults fire. Counts them.
class FaultInjector {
 public:
  FaultInjector(std::vector<Fault> faults, std::uint64_t seed);

  bool none() const { return faults_.empty(); }
  /// One byte in becomes zero, one or two. `outwards`: printer to host.
  void pass_byte(char byte, bool outwards, std::string& out);
  /// Faults that fire at the next line read (its number from 1 counts up here).
  std::vector<Fault> at_line();
  /// Faults that fire at the next ok.
  std::vector<Fault> at_ok();
  /// Faults due at `now`, s, and the time of the next one (infinity when there is none).
  std::vector<Fault> at_time(double now);
  double next_time() const;
  /// Whether the resend request being sent shall lack its ok.
  bool resend_lacks_ok();
  /// A number in [0, n).
  std::size_t pick(std::size_t n);
  /// Faults fired so far.
  std::uint64_t fired() const { return fired_; }

 private:
  std::vector<Fault> due(FaultTrigger trigger, std::uint64_t count);
  bool fires(Fault& fault, std::uint64_t count);
  bool chance(double probability);

  std::vector<Fault> faults_;
  std::mt19937_64 random_;
  std::uint64_t bytes_in_ = 0, bytes_out_ = 0, lines_ = 0, oks_ = 0, resends_ = 0;
  std::uint64_t fired_ = 0;
};

}  // namespace voidpath::test::mock
