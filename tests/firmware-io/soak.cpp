#include "tests/firmware-io/soak.h"

#include "tests/firmware-io/mock_bench.h"
#include "tests/firmware-io/witness.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <utility>

namespace voidpath::test {
namespace {

using mock::Fault;
using mock::FaultKind;
using mock::FaultTrigger;

constexpr double kLongest_s = 3 * 3600;
// Meanwhile it obeys nothing.
constexpr double kKlipperStarts_s = 1;
// Where a print waits for a person, one comes after so long and lets it go on.
constexpr double kPersonComes_s = 60;
// And so long after the last line somebody looks at the panel: not every printer says that it waits.
constexpr double kPersonLooks_s = 1800;

/// Dice that fall the same on every machine.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed * 0x9E3779B97F4A7C15u + 1) {}
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(random_() % n); }
  bool one_in(std::size_t n) { return below(n) == 0; }
  double between(double a, double b) {
    return a + (b - a) * static_cast<double>(random_() >> 11) / 9007199254740992.0;
  }
  /// Each power of ten as likely.
  double rate(double low, double high) { return std::pow(10, between(std::log10(low), std::log10(high))); }

 private:
  std::mt19937_64 random_;
};

std::vector<std::string> make_file(Dice& dice, std::size_t lines, bool level, bool heat) {
  std::vector<std::string> file = {"G21", "G90", "M82"};
  if (heat) file.insert(file.end(), {"M140 S60", "M109 S200", "M190 S60"});
  if (level) file.push_back("G29");
  for (std::size_t i = 0; i < lines; ++i)
    file.push_back("G1 X" + mock::fixed(dice.between(0, 200), 3) + " Y" +
                   mock::fixed(dice.between(0, 200), 3) + " E" +
                   mock::fixed(static_cast<double>(i) * 0.04321, 5));
  file.push_back("M220 S100");
  return file;
}

Fault by_chance(FaultKind kind, double probability, bool outwards = false) {
  Fault fault;
  fault.kind = kind;
  fault.trigger = mock::natural_trigger(kind);
  fault.probability = probability;
  fault.outwards = outwards;
  return fault;
}

Fault once(FaultKind kind, FaultTrigger trigger, double at) {
  Fault fault;
  fault.kind = kind;
  fault.trigger = trigger;
  fault.at = at;
  return fault;
}

// `wired`: bytes and oks may suffer as well.
Fault any_fault(Dice& dice, std::size_t lines, bool wired, std::string& what) {
  static constexpr FaultKind kBytes[] = {FaultKind::kFlipByte, FaultKind::kDropByte, FaultKind::kDoubleByte,
                                         FaultKind::kInsertByte};
  static constexpr FaultKind kLines[] = {FaultKind::kDropLine, FaultKind::kGarbleLine,
                                         FaultKind::kDoubleLine};
  const double line = 10 + static_cast<double>(dice.below(lines));
  Fault fault;
  constexpr std::size_t kOfWires = 13, kAll = 20;
  switch (wired ? dice.below(kAll) : kOfWires + dice.below(kAll - kOfWires)) {
    case 0:
    case 1:
    case 2:
    case 3: {
      const double rate = dice.rate(1e-5, 1e-2);
      what += " bytes";
      return by_chance(kBytes[dice.below(4)], rate, dice.one_in(2));
    }
    case 4:
      what += " lost-ok";
      return by_chance(FaultKind::kLoseOk, dice.rate(1e-3, 0.1));
    case 5:
      what += " double-ok";
      return by_chance(FaultKind::kDoubleOk, dice.rate(1e-3, 0.1));
    case 6:
      what += " garbled-ok";
      return by_chance(FaultKind::kGarbleOk, dice.rate(1e-3, 0.1));
    case 7:
      what += " resend-without-ok";
      return by_chance(FaultKind::kResendWithoutOk, 1);
    case 8:
      what += " burst";
      fault = once(kBytes[dice.below(4)], FaultTrigger::kByte, 1000 + 30 * line);
      fault.limit = 5 + dice.below(60);
      fault.outwards = dice.one_in(2);
      return fault;
    case 9:
    case 10:
    case 11:
      what += " lines";
      return by_chance(kLines[dice.below(3)], dice.rate(1e-3, 0.1));
    case 12:
      what += " spurious-resend";
      return by_chance(FaultKind::kSpuriousResend, dice.rate(1e-3, 0.1));
    case 13:
      what += " filament";
      return once(FaultKind::kPause, FaultTrigger::kLine, line);
    case 14:
      what += " dead-heater";
      fault = once(FaultKind::kDeadHeater, FaultTrigger::kLine, line);
      if (dice.one_in(2)) fault.heater = "bed";
      return fault;
    case 15:
      what += " reset";
      return once(FaultKind::kReset, FaultTrigger::kLine, line);
    case 16:
      what += " halt";
      return once(FaultKind::kHalt, FaultTrigger::kLine, line);
    case 17:
      what += " unplug";
      fault = once(FaultKind::kUnplug, FaultTrigger::kLine, line);
      fault.seconds = dice.between(0.1, 5);
      return fault;
    case 18:
      what += " silence";
      fault = once(FaultKind::kSilence, FaultTrigger::kLine, line);
      fault.seconds = dice.between(0.5, 20);
      return fault;
    default:
      what += " slow";
      fault = once(FaultKind::kSlow, FaultTrigger::kLine, line);
      fault.lines = 5;
      fault.seconds = dice.between(0.1, 3);
      return fault;
  }
}

// Until the print is over, or three hours have passed. A user may pause or cancel it meanwhile.
bool see_through(MockBench& bench, SoakPrint& print, const SoakHooks& hooks) {
  double comes = 0;
  bool came = false, paused = false, cancelled = false;
  int done = 0;
  double looks = bench.t() + kPersonLooks_s;
  return bench.run_until(
      [&] {
        if (std::exchange(done, bench.count<fw::LineDone>()) != done) looks = bench.t() + kPersonLooks_s;
        if (bench.t() >= looks) looks += kPersonLooks_s, bench.printer.press_button();
        if (hooks.pause_at > 0 && done >= hooks.pause_at && !std::exchange(paused, true))
          bench.driver.pause();
        if (hooks.cancel_at > 0 && done >= hooks.cancel_at && !std::exchange(cancelled, true))
          bench.driver.cancel("", bench.t());
        if (bench.count<fw::Paused>() == bench.count<fw::Resumed>()) {
          comes = 0;
          came = false;
        } else if (comes == 0) {
          comes = bench.t() + kPersonComes_s;
          const auto* said = bench.find<fw::Paused>(print.pauses++);
          if (said && said->by_printer && said->reason.empty()) print.violation = "paused without a reason";
        } else if (bench.t() >= comes) {
          // What is in the firmware's queue may stand before M108: then there is the panel.
          if (print.pauses % 2 == 0 || std::exchange(came, true)) bench.printer.press_button();
          bench.driver.resume(bench.t());
          comes = bench.t() + kPersonComes_s;
        }
        return bench.over();
      },
      kLongest_s);
}

}  // namespace

void show_dialogue(double s, char who, std::string_view bytes) {
  std::printf("%.4f %c ", s, who);
  for (const char c : bytes) {
    if (c == '\n')
      std::fputs("\\n", stdout);
    else if (c >= ' ' && c <= '~')
      std::putchar(c);
    else
      std::printf("\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(c)));
  }
  std::putchar('\n');
  std::fflush(stdout);
}

SoakPrint play(const mock::Options& options, std::vector<std::string> file, const SoakHooks& hooks) {
  const SoakTrace& trace = hooks.trace;
  SoakPrint print;
  MockBench bench(options);
  Witness witness;
  bench.on_output = [&](const std::string& bytes) {
    witness.sent(bytes);
    if (trace) trace(bench.printer.now(), '>', bytes);
  };
  if (trace) bench.on_input = [&](const std::string& bytes) { trace(bench.printer.now(), '<', bytes); };
  double last_s = 0;
  bool printing = false;
  bench.printer.on_accepted([&](std::string_view text, std::optional<std::int64_t> number) {
    witness.accepted(text, number);
    if (trace)
      trace(bench.printer.now(), '=', (number ? std::to_string(*number) : "-") + " " + std::string(text));
    if (printing && last_s > 0)
      print.longest_gap_s = std::max(print.longest_gap_s, bench.printer.now() - last_s);
    last_s = bench.printer.now();
  });
  bench.to_printer = hooks.to_printer;
  bench.to_host = hooks.to_host;
  bench.read_every_s = hooks.read_every_s;
  const auto ready = [&] { return bench.connected(); };
  if (!bench.run_until(ready, 600)) {
    print.ended = bench.count<fw::Disconnected>() > 0;
    print.reason = "never connected";
    return print;
  }
  bench.run_until([&] { return bench.count<fw::LimitsKnown>() > 0; }, 5);
  witness.lines.clear(), witness.taken.clear();
  const int before = witness.invisible;
  printing = true;
  last_s = 0;
  bench.print(file);
  print.ended = see_through(bench, print, hooks);
  printing = false;
  const bool cancelled = bench.count<fw::PrintCancelled>() > 0;
  if (cancelled) print.reason = "cancelled", bench.run_for(kPersonComes_s);
  print.finished = bench.count<fw::PrintFinished>() > 0;
  if (const auto* failed = bench.find<fw::PrintFailed>()) print.reason = failed->reason;
  if (const auto* stats = bench.find<fw::LinkStats>(bench.count<fw::LinkStats>() - 1))
    print.noticed = stats->doubts > 0;
  print.invisible = witness.invisible - before;
  print.resends = bench.printer.statistics().resends;
  if (!witness.violation.empty()) print.violation = witness.violation;
  file = of_file(file);
  const auto sent = of_file(witness.lines), taken = of_file(witness.taken);
  const auto is_prefix = [&](const std::vector<std::string>& part) {
    return part.size() <= file.size() && std::equal(part.begin(), part.end(), file.begin());
  };
  if (!is_prefix(sent)) print.violation = "what was sent is not the file";
  if (print.invisible == 0 && !is_prefix(taken)) print.violation = "what was taken is not the file";
  if (print.invisible == 0 && print.finished && taken.size() != file.size())
    print.violation = "finished without all lines";
  if (!print.ended) print.violation = "neither finished nor halted";
  if (print.ended && !print.finished && print.reason.empty()) print.violation = "halted without a reason";
  if (cancelled && print.invisible == 0 &&
      (bench.printer.hotend().target() > 0 || bench.printer.bed().target() > 0))
    print.violation = "cancelled and still hot";
  print.bytes_lost = bench.printer.statistics().bytes_dropped;
  return print;
}

SoakPrint soak_print(std::uint64_t seed, const SoakTrace& trace) {
  Dice dice(seed);
  static constexpr const char* kFirmwares[] = {"marlin2",  "marlin2",  "marlin2", "marlin1", "prusa",
                                               "smoothie", "repetier", "klipper", "marlin10"};
  const std::string firmware = kFirmwares[dice.below(9)];
  static constexpr std::size_t kRings[] = {128, 128, 64, 1024};
  static constexpr std::size_t kTerminal = 4096;  // Klipper's, whose writer waits while it is full
  const std::size_t ring = kRings[dice.below(4)];
  const bool wired = firmware != "klipper";
  mock::Options options = mock::make_mock()
                              .firmware(firmware)
                              .baud(dice.one_in(2) ? 115200 : 250000)
                              .round_trip(dice.one_in(4) ? 0.016 : 0.001)
                              .rx_buffer(wired ? ring : kTerminal)
                              .advanced_ok(firmware == "marlin2" && dice.one_in(2))
                              .emergency_parser(dice.one_in(2))
                              .meatpack(firmware == "marlin2" && dice.one_in(3))
                              .instant_moves()
                              .cold_extrusion()
                              .seed(seed)
                              .build();
  if (!wired) options.boot_s = kKlipperStarts_s;
  std::string what = std::to_string(seed) + " " + firmware + (options.meatpack ? "+meatpack" : "") + ":";
  const std::size_t lines = 60 + dice.below(240);
  const bool level = dice.one_in(8);
  if (level) {
    options.leveling_s = 600;
    options.dialect.busy = false;
    what += " ten-silent-minutes";
  }
  for (std::size_t n = 1 + dice.below(3); n > 0; --n)
    options.faults.push_back(any_fault(dice, lines, wired, what));
  SoakHooks hooks{.trace = trace};
  if (dice.one_in(6)) hooks.read_every_s = 0.05, what += " slow-reader";
  const bool heat = dice.one_in(6);
  if (heat) what += " heated";
  std::vector<std::string> file = make_file(dice, lines, level, heat);
  const auto some = [&] { return static_cast<int>(1 + dice.below(file.size())); };
  if (dice.one_in(8)) hooks.pause_at = some(), what += " paused";
  if (dice.one_in(8)) hooks.cancel_at = some(), what += " cancelled";
  if (!wired) file.insert(file.begin(), "G28");  // without which it refuses to move
  SoakPrint print = play(options, std::move(file), hooks);
  print.what = what;
  return print;
}

SoakPrint noisy_print(std::uint64_t seed, const SoakTrace& trace) {
  static constexpr double kRate = 1e-4;
  static constexpr FaultKind kKinds[] = {FaultKind::kFlipByte, FaultKind::kFlipByte, FaultKind::kDropByte,
                                         FaultKind::kDoubleByte, FaultKind::kInsertByte};
  static constexpr const char* kFirmwares[] = {"marlin2", "marlin2",  "marlin1",
                                               "prusa",   "repetier", "smoothie"};
  Dice dice(seed);
  const std::string firmware = kFirmwares[dice.below(6)];
  const bool fast = dice.one_in(2), far = dice.one_in(4), packed = firmware == "marlin2" && dice.one_in(3);
  mock::Options options = mock::make_mock()
                              .firmware(firmware)
                              .baud(fast ? 250000 : 115200)
                              .round_trip(far ? 0.016 : 0.001)
                              .advanced_ok(firmware == "marlin2" && dice.one_in(2))
                              .meatpack(packed)
                              .instant_moves()
                              .cold_extrusion()
                              .seed(seed)
                              .build();
  options.faults = {by_chance(kKinds[dice.below(5)], kRate), by_chance(kKinds[dice.below(5)], kRate, true)};
  SoakPrint print = play(options, make_file(dice, 1000, false, false), {.trace = trace});
  print.what = std::to_string(seed) + " " + firmware + (packed ? "+meatpack" : "") + (fast ? " 250000" : "") +
               (far ? " 16 ms" : "") + " one in 10 kB";
  return print;
}

}  // namespace voidpath::test
