#pragma once

#include "tests/firmware-io/soak.h"
#include "tests/fuzz/check.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

/// What the fuzz target of a print over a hostile wire runs: also called with seeded random input by the
/// tests.
namespace voidpath::test {

/// A driver prints on a mock printer; the input says which printer, what breaks in it, and what happens to
/// each piece that passes on the wire, either way. What is left when the input is used up passes unharmed.
class HostileWire {
 public:
  HostileWire(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  SoakPrint run(const SoakTrace& trace = {}) {
    static constexpr const char* kFirmwares[] = {"marlin2", "marlin1", "prusa", "smoothie"};
    static constexpr std::size_t kRings[] = {128, 64, 1024, 128};
    const unsigned kind = take(), more = take();
    mock::Options options = mock::make_mock()
                                .firmware(kFirmwares[kind % 4])
                                .baud(kind & 4U ? 115200 : 250000)
                                .round_trip(kind & 8U ? 0.016 : 0.001)
                                .rx_buffer(kRings[(kind >> 4) % 4])
                                .advanced_ok(kind % 4 == 0 && (kind & 64U) != 0)
                                .meatpack(kind % 4 == 0 && (kind & 128U) != 0)
                                .emergency_parser(more & 1U)
                                .instant_moves()
                                .cold_extrusion()
                                .seed(more)
                                .build();
    for (unsigned n = (more >> 1) % 4; n > 0; --n) options.faults.push_back(fault());
    std::vector<std::string> file = {"G21", "G90", "M82"};
    if (more & 64U) {
      file.push_back("G29");
      options.leveling_s = 600;
      options.dialect.busy = (more & 128U) != 0;
    }
    for (unsigned i = 0; i < 30; ++i)
      file.push_back("G1 X" + std::to_string(i * 7 % 200) + ".5 E" + std::to_string(i) + ".25");
    return play(options, std::move(file),
                {.trace = trace,
                 .to_printer = [this](std::string text) { return damaged(std::move(text), kIntoPrinter); },
                 .to_host = [this](std::string text) { return damaged(std::move(text), kIntoHost); }});
  }

 private:
  // No `o`, `k` or line end comes from nowhere on the way back: a forged ok or answer is another matter than
  // damage, and no host could tell.
  static constexpr std::string_view kIntoPrinter = "\n*N0G1 ;\x80";
  static constexpr std::string_view kIntoHost = "#1:R/ E\x80";

  unsigned take() { return at_ < size_ ? data_[at_++] : 0U; }

  mock::Fault fault() {
    using mock::FaultKind;
    static constexpr FaultKind kKinds[] = {FaultKind::kLoseOk,
                                           FaultKind::kDoubleOk,
                                           FaultKind::kGarbleOk,
                                           FaultKind::kReset,
                                           FaultKind::kHalt,
                                           FaultKind::kUnplug,
                                           FaultKind::kSlow,
                                           FaultKind::kSpuriousResend,
                                           FaultKind::kSilence,
                                           FaultKind::kPause,
                                           FaultKind::kResendWithoutOk,
                                           FaultKind::kDoubleLine};
    mock::Fault fault;
    fault.kind = kKinds[take() % std::size(kKinds)];
    fault.trigger = mock::natural_trigger(fault.kind);
    fault.at = 1 + take() % 64;
    fault.seconds = take() % 16;
    fault.lines = 1 + take() % 4;
    if (fault.kind == FaultKind::kResendWithoutOk) fault.at.reset(), fault.probability = 1;
    return fault;
  }

  std::string damaged(std::string text, std::string_view letters) {
    const unsigned what = take();
    if (what < 192 || text.empty()) return text;
    for (unsigned n = 1 + (what >> 4) % 4; n > 0 && !text.empty(); --n) {
      const unsigned how = take();
      const std::size_t at = take() % text.size();
      switch (how % 5) {
        case 0:
          text.erase(at, 1);
          break;
        case 1:
          text[at] = letters[(how >> 4) % letters.size()];
          break;
        case 2:
          text.insert(at, 1, text[at]);
          break;
        case 3:
          text.insert(at, 1, letters[(how >> 4) % letters.size()]);
          break;
        default:
          text.erase(at, 1 + (how >> 3));
          break;
      }
    }
    return text;
  }

  const std::uint8_t* data_;
  std::size_t size_;
  std::size_t at_ = 0;
};

/// With VOIDPATH_SHOW in its environment it prints the dialogue.
inline void fuzz_marlin_wire(const std::uint8_t* data, std::size_t size) {
  const SoakPrint print =
      HostileWire(data, size).run(std::getenv("VOIDPATH_SHOW") ? show_dialogue : SoakTrace{});
  require(print.violation.empty(), print.violation.c_str());
}

}  // namespace voidpath::test
