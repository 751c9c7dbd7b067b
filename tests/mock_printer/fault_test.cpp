#include "tests/mock_printer/host_for_test.h"

#include <catch2/catch.hpp>

using namespace voidpath::test::mock;

namespace {

/// What two numbered lines cause under one fault.
std::string two_lines(Rig& rig) { return say(rig.printer, numbered(1, "G90") + numbered(2, "M82")); }

Fault at_line(FaultKind kind, double line) {
  Fault f;
  f.kind = kind;
  f.at = line;
  return f;
}

}  // namespace

TEST_CASE("a flipped or lost byte is noticed") {
  for (const FaultKind kind : {FaultKind::kFlipByte, FaultKind::kDropByte, FaultKind::kDoubleByte}) {
    Rig rig(make_mock().fault(kind, 4).build());
    CHECK(two_lines(rig).find("Resend: 1\n") != std::string::npos);
    CHECK(rig.printer.statistics().faults == 1);
    CHECK(rig.printer.statistics().resends == 2);
  }
}

TEST_CASE("a line can vanish, be damaged or come twice") {
  Rig lost(make_mock().fault(FaultKind::kDropLine, 1).build());
  CHECK(two_lines(lost).find("Error:Line Number") == 0);
  Rig garbled(make_mock().seed(3).fault(FaultKind::kGarbleLine, 2).build());
  const std::string heard = two_lines(garbled);
  CHECK(heard.find("ok\n") == 0);
  CHECK(garbled.log != std::vector<std::string>{"G90", "M82"});
  Rig twice(make_mock().fault(FaultKind::kDoubleLine, 1).build());
  CHECK(two_lines(twice) == "ok\nok\n");  // the repeat is dropped without a word
}

TEST_CASE("an ok can be lost, doubled or damaged") {
  Rig lost(make_mock().lose_ok(1).build());
  CHECK(two_lines(lost) == "ok\n");
  CHECK(lost.log.size() == 2);
  Rig twice(make_mock().fault(FaultKind::kDoubleOk, 2).build());
  CHECK(two_lines(twice) == "ok\nok\nok\n");
  Rig garbled(make_mock().fault(FaultKind::kGarbleOk, 1).build());
  CHECK(count_of(two_lines(garbled), "ok\n") == 1);
}

TEST_CASE("resends come without ok, or without reason") {
  Rig silent(make_mock().fault(FaultKind::kResendWithoutOk, 1).build());
  CHECK(say(silent.printer, "N5 G28*0\n").find("ok") == std::string::npos);
  CHECK(say(silent.printer, "N5 G28*0\n").find("ok") != std::string::npos);
  Rig spurious(make_mock().fault(FaultKind::kSpuriousResend, 2).build());
  CHECK(two_lines(spurious).find("ok\nError:checksum mismatch, Last Line: 1\nResend: 2\nok\n") == 0);
  CHECK(say(spurious.printer, numbered(2, "M82")) == "ok\n");
}

TEST_CASE("a reset forgets line numbers, heaters and position") {
  Rig rig(make_mock().fault(FaultKind::kReset, 3).build());
  say(rig.printer, numbered(1, "M104 S200") + numbered(2, "G1 X50 F600"));
  CHECK(say(rig.printer, numbered(3, "G1 X60")).find("start\n") == 0);
  CHECK(rig.printer.hotend().target() == 0);
  CHECK(rig.printer.motion().drained());
  CHECK(say(rig.printer, numbered(4, "G90")).find("Resend: 1\n") != std::string::npos);
  CHECK(rig.printer.statistics().resets == 1);
}

TEST_CASE("a halt can be ordered at a line or a time") {
  Fault fault = at_line(FaultKind::kHalt, 2);
  fault.text = "MINTEMP triggered";
  Rig rig(make_mock().fault(fault).build());
  CHECK(two_lines(rig).find("Error:MINTEMP triggered, system stopped! Heater_ID: E0\n") != std::string::npos);
  fault.trigger = FaultTrigger::kTime;
  fault.at = 30;
  Rig later(make_mock().fault(fault).build());
  CHECK(say(later.printer, "", 29.9).empty());
  CHECK_FALSE(say(later.printer, "", 0.2).empty());
  CHECK(later.printer.halted());
}

TEST_CASE("silence: nothing is read or said, motion goes on") {
  Fault fault = at_line(FaultKind::kSilence, 2);
  fault.seconds = 60;
  Rig rig(make_mock().fault(fault).build());
  say(rig.printer, numbered(1, "G1 X100 F3000"));
  CHECK(say(rig.printer, numbered(2, "G90") + numbered(3, "G91"), 59).empty());
  CHECK(rig.printer.statistics().motion_s > 1);
  CHECK(say(rig.printer, "", 2) == "ok\nok\n");
}

TEST_CASE("a slow printer takes its time for each command") {
  Fault fault = at_line(FaultKind::kSlow, 1);
  fault.seconds = 0.5;
  fault.lines = 2;
  Rig rig(make_mock().fault(fault).build());
  CHECK(count_of(say(rig.printer, "G90\nG90\nG90\n", 0.6), "ok\n") == 1);
  CHECK(count_of(say(rig.printer, "", 0.6), "ok\n") == 2);
}

TEST_CASE("the cable comes out, once, for so long") {
  Fault fault = at_line(FaultKind::kUnplug, 1);
  fault.seconds = 3;
  Rig rig(make_mock().fault(fault).build());
  CHECK_FALSE(rig.printer.take_unplug());
  say(rig.printer, "G90\n");
  CHECK(rig.printer.take_unplug() == 3.0);
  CHECK_FALSE(rig.printer.take_unplug());
}

TEST_CASE("the printer pauses by itself and neither logs nor acknowledges that") {
  Rig rig(make_mock().fault(FaultKind::kPause, 1).build());
  const std::string heard = say(rig.printer, "G90\n", 5);
  CHECK(heard.find("//action:paused\n") != heard.npos);
  CHECK(heard.find("ok") == heard.npos);
  const std::string after = say(rig.printer, "M108\n");
  CHECK(count_of(after, "ok\n") == 2);
  CHECK(rig.log == std::vector<std::string>{"G90", "M108"});
}

TEST_CASE("noise depends on the seed alone") {
  const auto heard = [](std::uint64_t seed) {
    Rig rig(make_mock().seed(seed).noise(FaultKind::kFlipByte, 0.01).build());
    std::string all;
    for (int n = 1; n <= 200; ++n) all += say(rig.printer, numbered(n, "G90"));
    CHECK(rig.printer.statistics().faults > 5);
    return all;
  };
  CHECK(heard(1) == heard(1));
  CHECK(heard(1) != heard(2));
}

TEST_CASE("a script reads as it is written, and mistakes have a line") {
  const auto faults = parse_faults(
      "faults:\n"
      "  - {kind: flip_byte, direction: out, probability: 1e-4, count: 5}\n"
      "  - {kind: lose_ok, ok: 40}\n"
      "  - {kind: halt, time: 30, text: Heating failed, heater: bed}\n");
  REQUIRE(faults.size() == 3);
  CHECK(faults[0].outwards);
  CHECK(faults[0].probability == 1e-4);
  CHECK(faults[0].limit == 5);
  CHECK(faults[1].trigger == FaultTrigger::kOk);
  CHECK(faults[2].trigger == FaultTrigger::kTime);
  CHECK(faults[2].text == "Heating failed");
  CHECK(parse_faults("faults:\n").empty());
  using Catch::Matchers::Contains;
  CHECK_THROWS_WITH(parse_faults("faults:\n  - {kind: lose_ok, ok: 1}\n  - {kind: lose_oks, ok: 1}\n"),
                    Contains("line 3") && Contains("lose_oks"));
  CHECK_THROWS_WITH(parse_faults("faults:\n  - {kind: reset}\n"), Contains("say when"));
  CHECK_THROWS_WITH(parse_faults("- {kind: reset, line: 3, sped: 2}\n"), Contains("sped"));
  CHECK_THROWS_WITH(parse_faults("- {kind: flip_byte, line: 3}\n"), Contains("at a byte"));
  CHECK_THROWS_WITH(load_faults("/nonexistent/faults.yaml"), Contains("cannot read"));
}
