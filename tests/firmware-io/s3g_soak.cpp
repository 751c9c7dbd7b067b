#include "firmware-io/s3g/encoder.h"
#include "firmware-io/s3g/packet.h"
#include "tests/firmware-io/s3g_bench.h"
#include "tests/firmware-io/soak.h"

#include <cmath>
#include <random>
#include <set>

namespace voidpath::test {
namespace {

using Lines = std::vector<std::string>;
using mock::Fault;
using mock::FaultKind;
using mock::FaultTrigger;

constexpr double kLongest_s = 3 * 3600;

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed * 0x9E3779B97F4A7C15u + 2) {}
  unsigned below(unsigned n) { return static_cast<unsigned>(random_() % n); }
  bool one_in(unsigned n) { return below(n) == 0; }
  /// Each power of ten as likely.
  double rate(double low, double high) {
    const double share = static_cast<double>(random_() >> 11) / 9007199254740992.0;
    return std::pow(10, std::log10(low) + (std::log10(high) - std::log10(low)) * share);
  }

 private:
  std::mt19937_64 random_;
};

Lines make_file(Dice& dice) {
  Lines file = {"M136",        "M73 P0",         "G162 X Y F2000",
                "G161 Z F900", "M132 X Y Z A B", "G1 X0 Y0 Z10 F3300",
                "M104 S100",   "M109 S100",      "M83",
                "G92 E0"};
  const auto place = [&](unsigned half) {
    return std::to_string(static_cast<int>(dice.below(2 * half)) - static_cast<int>(half));
  };
  for (unsigned i = 20 + dice.below(60); i > 0; --i) {
    file.push_back("G1 X" + place(90) + " Y" + place(60) + " E0." + std::to_string(100 + dice.below(900)) +
                   " F" + std::to_string(1200 + dice.below(4800)));
    if (dice.one_in(9)) file.push_back("G1 E-1.5 F1500"), file.push_back("G1 E1.5 F1500");
    if (dice.one_in(15)) file.push_back("M106 S255");
  }
  file.insert(file.end(), {"M104 S0", "M73 P100", "M137"});
  return file;
}

Fault any_fault(Dice& dice, std::string& what) {
  static constexpr FaultKind kBytes[] = {FaultKind::kFlipByte, FaultKind::kDropByte, FaultKind::kDoubleByte,
                                         FaultKind::kInsertByte};
  static constexpr FaultKind kPackets[] = {FaultKind::kDropLine, FaultKind::kGarbleLine, FaultKind::kLoseOk,
                                           FaultKind::kGarbleOk, FaultKind::kDoubleOk};
  static constexpr FaultKind kOnce[] = {FaultKind::kReset, FaultKind::kDeadHeater, FaultKind::kSilence,
                                        FaultKind::kSlow,  FaultKind::kCancel,     FaultKind::kBusy};
  Fault fault;
  const unsigned which = dice.below(16);
  if (which < 5) {
    what += " bytes";
    fault.kind = kBytes[dice.below(4)];
    fault.outwards = dice.one_in(2);
    fault.probability = dice.rate(1e-5, fault.outwards ? 1e-2 : 1e-3);
  } else if (which < 10) {
    what += " packets";
    fault.kind = kPackets[which - 5];
    fault.probability = dice.rate(1e-3, 5e-2);
  } else {
    fault.kind = kOnce[which - 10];
    what += " once-" + std::to_string(which - 10);
    fault.at = 1 + dice.below(120);
    fault.seconds = dice.one_in(8) ? 600 : 1 + dice.below(30);
    fault.lines = 1 + dice.below(5);
    fault.trigger = FaultTrigger::kTime;
    return fault;
  }
  fault.trigger = mock::natural_trigger(fault.kind);
  return fault;
}

Lines expected(const Lines& file) {
  fw::s3g::Encoder encoder((fw::s3g::Machine()));
  Lines out{encoder.build_start("voidpath").payload};
  for (const std::string& line : file)
    for (const fw::s3g::Action& action : encoder.encode(line).actions) out.push_back(action.payload);
  if (encoder.build_started()) out.push_back(encoder.build_end().payload);
  return out;
}

bool moves_filament(const std::string& payload) {
  return static_cast<unsigned char>(payload[0]) == 155 &&
         (fw::s3g::little_endian(payload, 13, 4) | fw::s3g::little_endian(payload, 17, 4)) != 0;
}

// Idempotent commands may come twice, and never does a move of filament. What ends a failed print follows
// behind and moves none.
std::string judge(const Lines& executed, const Lines& want, bool finished) {
  std::size_t at = 0;
  bool ending = false;
  for (const std::string& payload : executed) {
    if (!ending && at < want.size() && payload == want[at]) {
      ++at;
    } else if (ending || at == 0 || payload != want[at - 1] || moves_filament(payload)) {
      if (finished) return "executed out of order: " + fw::s3g::hex(payload);
      if (moves_filament(payload)) return "filament moved out of order: " + fw::s3g::hex(payload);
      ending = true;
    }
  }
  return finished && at < want.size() ? "finished without all commands" : "";
}

}  // namespace

SoakPrint s3g_soak_print(std::uint64_t seed, const SoakTrace& trace) {
  Dice dice(seed);
  SoakPrint print;
  print.what = std::to_string(seed) + " s3g:";
  mock::S3gOptions options;
  options.baud = 115200;
  options.round_trip_s = dice.one_in(4) ? 0.016 : 0.001;
  options.counts_lines = !dice.one_in(3);
  options.seed = seed;
  const Lines file = make_file(dice);
  for (unsigned n = 1 + dice.below(3); n > 0; --n) options.faults.push_back(any_fault(dice, print.what));
  S3gBench bench(options);
  std::set<std::string> sent;
  fw::s3g::PacketReader reader;
  const auto heard = [&](char who, const std::string& bytes) {
    if (trace) trace(bench.t, who, fw::s3g::hex(bytes));
  };
  bench.on_input = [&](const std::string& bytes) { heard('<', bytes); };
  bench.mock.on_payload([&](const std::string& payload) {
    bench.executed.push_back(payload);
    heard('=', payload);
  });
  bench.on_output = [&](const std::string& bytes) {
    heard('>', bytes);
    for (const char c : bytes)
      if (const auto packet = reader.take(c); packet && packet->good) sent.insert(packet->payload);
  };
  if (!bench.run_until([&] { return bench.count<fw::Connected>() > 0 || bench.driver.closing(); }, 600) ||
      bench.driver.closing()) {
    print.ended = true;
    print.reason = "never connected";
    return print;
  }
  bench.executed.clear();
  print.ended = bench.print_through(file, kLongest_s);
  print.finished = bench.count<fw::PrintFinished>() > 0;
  print.reason = bench.count<fw::PrintCancelled>() > 0 ? "cancelled at the panel" : bench.failure();
  // A damaged packet passes the CRC once in 256: what was never sent was obeyed.
  for (const std::string& payload : bench.executed) print.invisible += sent.count(payload) == 0 ? 1 : 0;
  // What a restarted printer is sent until that is noticed belongs to nothing.
  const bool restarted = print.reason.find("restarted") != std::string::npos;
  if (print.invisible == 0 && !restarted) {
    print.violation = judge(bench.executed, expected(file), print.finished);
    if (print.violation.empty() && !bench.mock.violations().empty())
      print.violation = bench.mock.violations().front();
  }
  if (!print.ended) print.violation = "neither finished nor halted";
  if (print.ended && !print.finished && print.reason.empty()) print.violation = "halted without a reason";
  return print;
}

}  // namespace voidpath::test
