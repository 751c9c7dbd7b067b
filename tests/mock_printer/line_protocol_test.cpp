#include "tests/mock_printer/host_for_test.h"

#include <catch2/catch.hpp>

using namespace voidpath::test::mock;

namespace {

const Dialect kMarlin = *find_dialect("marlin2");

/// The result of the last line in `bytes`.
LineResult last_result(LineProtocol& protocol, std::string_view bytes) {
  std::optional<LineResult> result;
  for (const char c : bytes)
    if (auto r = protocol.take(c)) result = r;
  REQUIRE(result);
  return *result;
}

std::string accepted(LineProtocol& protocol, std::string_view bytes) {
  return std::get<AcceptedLine>(last_result(protocol, bytes)).text;
}

}  // namespace

TEST_CASE("the checksum is the xor of all before the star") {
  // N0 M110 N0*125 is the example every host begins with.
  CHECK(checksum_of("N0 M110 N0") == 125);
}

TEST_CASE("a numbered line passes in order and loses number and checksum") {
  LineProtocol p(kMarlin);
  CHECK(accepted(p, numbered(1, "G1 X1 Y2")) == "G1 X1 Y2");
  CHECK(accepted(p, numbered(2, "G1 X2")) == "G1 X2");
  CHECK(p.last_number() == 2);
}

TEST_CASE("a wrong number, a wrong sum and a missing sum are refused with the line wanted") {
  LineProtocol p(kMarlin);
  accepted(p, numbered(1, "G28"));
  const auto gap = std::get<RefusedLine>(last_result(p, numbered(3, "G1 X1")));
  CHECK(gap.error == "Line Number is not Last Line Number+1, Last Line: 1");
  CHECK(gap.resend == 2);
  const auto sum = std::get<RefusedLine>(last_result(p, "N2 G1 X1*1\n"));
  CHECK(sum.error == "checksum mismatch, Last Line: 1");
  const auto none = std::get<RefusedLine>(last_result(p, "N2 G1 X1\n"));
  CHECK(none.error == "No Checksum with line number, Last Line: 1");
  CHECK(p.last_number() == 1);
}

TEST_CASE("a repeat of the last or last-but-one line is dropped without a word, an older one refused") {
  LineProtocol p(kMarlin);
  for (int n = 1; n <= 3; ++n) accepted(p, numbered(n, "G4 P0"));
  CHECK(std::holds_alternative<IgnoredLine>(last_result(p, numbered(3, "G4 P0"))));
  CHECK(std::holds_alternative<IgnoredLine>(last_result(p, numbered(2, "G4 P0"))));
  CHECK(std::holds_alternative<RefusedLine>(last_result(p, numbered(1, "G4 P0"))));
  LineProtocol old(*find_dialect("marlin1"));
  for (int n = 1; n <= 2; ++n) accepted(old, numbered(n, "G4 P0"));
  CHECK(std::holds_alternative<RefusedLine>(last_result(old, numbered(2, "G4 P0"))));
}

TEST_CASE("M110 sets the number at receipt: its second N, else the leading one") {
  LineProtocol p(kMarlin);
  CHECK(accepted(p, numbered(0, "M110 N41")) == "M110 N41");
  CHECK(p.last_number() == 41);
  accepted(p, numbered(7, "M110"));
  CHECK(p.last_number() == 7);
  CHECK(accepted(p, numbered(8, "G28")) == "G28");
  CHECK(std::holds_alternative<RefusedLine>(last_result(p, "N9 M110 N0*1\n")));
}

TEST_CASE("comments and escapes go before the checksum is looked at") {
  LineProtocol p(kMarlin);
  CHECK(std::holds_alternative<IgnoredLine>(last_result(p, "; only a comment\n")));
  CHECK(std::get<IgnoredLine>(last_result(p, "\r\n")).blank);
  CHECK(accepted(p, "G1 X1 ; go\n") == "G1 X1");
  // The host summed the comment; the firmware never saw it, nor the star behind it.
  CHECK(std::holds_alternative<RefusedLine>(last_result(p, numbered(1, "G1 X1;go"))));
  CHECK(std::holds_alternative<RefusedLine>(last_result(p, numbered(1, "M117 a\\b"))));
  CHECK(accepted(p, "G1 X12\b3\n") == "G1 X13");
  CHECK(accepted(p, "G1 (a) X1\n") == "G1 (a) X1");
  LineProtocol parentheses(kMarlin, true);
  CHECK(accepted(parentheses, "G1 (a)X1\n") == "G1 X1");
}

TEST_CASE("a zero byte ends what is seen of a line, which so lacks its checksum") {
  LineProtocol protocol(*find_dialect("marlin2"));
  const auto take = [&](std::string_view bytes) {
    std::optional<LineResult> result;
    for (const char c : bytes) result = protocol.take(c);
    return result;
  };
  const auto result =
      take(std::string_view("N1 M1\0"
                            "05*38\n",
                            12));
  REQUIRE(result);
  REQUIRE(std::holds_alternative<RefusedLine>(*result));
  CHECK(std::get<RefusedLine>(*result).error == "No Checksum with line number, Last Line: 0");
}

TEST_CASE("at most 95 characters of a line are kept") {
  LineProtocol p(kMarlin);
  const std::string fits = numbered(1, "M117 " + std::string(95 - 5 - 3 - 4, 'x'));
  REQUIRE(fits.size() <= 96);
  CHECK(accepted(p, fits).size() == 88);
  const auto cut = std::get<RefusedLine>(last_result(p, numbered(2, "M117 " + std::string(90, 'x'))));
  CHECK(cut.error.substr(0, 11) == "No Checksum");
  CHECK(accepted(p, "M117 " + std::string(200, 'x') + "\n").size() == 95);
}

TEST_CASE("leading blanks are not summed, trailing ones are cut") {
  LineProtocol p(kMarlin);
  CHECK(accepted(p, "   " + numbered(1, "G28")) == "G28");
  CHECK(accepted(p, "    \n").empty());
}

TEST_CASE("an unnumbered line is obeyed unchecked by Marlin 2, refused with a star by Marlin 1") {
  LineProtocol p(kMarlin);
  CHECK(accepted(p, "G1 X9*3\n") == "G1 X9");
  LineProtocol old(*find_dialect("marlin1"));
  const auto refused = std::get<RefusedLine>(last_result(old, "G1 X9*3\n"));
  CHECK(refused.error == "No Line Number with checksum, Last Line: 0");
  CHECK(accepted(old, "G1 X9\n") == "G1 X9");
}

TEST_CASE("Marlin sums to the last star, Prusa to the first") {
  const std::string line = numbered(1, "M117 a*b");
  LineProtocol marlin(kMarlin), prusa(*find_dialect("prusa"));
  CHECK(std::holds_alternative<AcceptedLine>(last_result(marlin, line)));
  CHECK(std::holds_alternative<RefusedLine>(last_result(prusa, line)));
}

TEST_CASE("Repetier ends a line at a colon and counts in 16 bits") {
  LineProtocol p(*find_dialect("repetier"));
  accepted(p, numbered(65535, "M110"));
  CHECK(std::holds_alternative<AcceptedLine>(last_result(p, numbered(0, "G28"))));
  const auto refused = std::get<RefusedLine>(last_result(p, numbered(5, "G28")));
  CHECK(refused.error == "expected line 1 got 5");
  CHECK(accepted(p, "G4 P0:") == "G4 P0");
}

TEST_CASE("Repetier skips what was under way when it asked, until what it wants has come") {
  LineProtocol p(*find_dialect("repetier"));
  accepted(p, numbered(1, "G28"));
  CHECK(std::holds_alternative<RefusedLine>(last_result(p, numbered(3, "G28"))));
  p.note_request();
  for (int i = 0; i < 3; ++i) CHECK(std::get<SkippedLine>(last_result(p, numbered(4, "G28"))).number == 4);
  CHECK(std::holds_alternative<RefusedLine>(last_result(p, "N5 G28*1\n")));
  accepted(p, numbered(2, "G28"));
  CHECK(std::holds_alternative<RefusedLine>(last_result(p, numbered(4, "G28"))));
  p.note_request();
  for (int i = 0; i < 15; ++i) last_result(p, numbered(4, "G28"));
  CHECK(std::holds_alternative<RefusedLine>(last_result(p, numbered(4, "G28"))));
}
