#include "firmware-io/marlin/codec.h"

#include <vector>

#include <catch2/catch.hpp>

using namespace voidpath::fw::marlin;

TEST_CASE("a line is framed with number and checksum", "[codec]") {
  CHECK(frame(0, "M110 N0") == "N0 M110 N0*125\n");
  // 'N'^'3'^' '^'T'^'0'^'*' computed by hand: 4E^33=7D, ^20=5D, ^54=09, ^30=39 = 57.
  CHECK(frame(3, "T0") == "N3 T0*57\n");
  CHECK(checksum("") == 0);
}

TEST_CASE("the longest payload still fits Marlin's line after a year of lines", "[codec]") {
  const std::string framed = frame(999'999'999, std::string(kMaxPayload, 'X'));
  CHECK(framed.size() - 1 <= kMaxFramed);
}

TEST_CASE("only moves lose their blanks: elsewhere they may divide two commands", "[codec]") {
  const auto dense = [](const char* payload) {
    std::string out;
    append_dense_frame(out, 3, payload);
    return out.substr(0, out.find('*'));
  };
  CHECK(dense("G1 X1 Y2") == "N3G1X1Y2");
  CHECK(dense("G3 I1 J2") == "N3G3I1J2");
  CHECK(dense("G0X1 Y2") == "N3G0X1Y2");
  for (const char* other : {"G53 G1 X1", "G28 X Y", "G1.5 X1", "G92 E0", "G0", "M104 S0", "T0"})
    CHECK(dense(other) == "N3 " + std::string(other));
}

TEST_CASE("sanitising leaves only what reaches the checksum unaltered", "[codec]") {
  CHECK(sanitise("  G1 X1 ; to the right") == "G1 X1");
  CHECK(sanitise("G1 (fast) X1\r") == "G1  X1");
  CHECK(sanitise("; only a comment").empty());
  CHECK(sanitise(" \t ").empty());
  CHECK(sanitise("M117 a*b\\c(d)") == "M117 abcd");
  CHECK(sanitise("M117 na\xC3\xAFve") == "M117 nave");
  CHECK(sanitise("G1\tX1") == "G1 X1");
  CHECK(sanitise("\xFF\tG1 X1") == "G1 X1");
  CHECK(sanitise("G1 X1\bY2") == "G1 X1Y2");
  CHECK(sanitise("G1 X10*87") == "G1 X10");
  CHECK(sanitise("M862.1 P0.4 *17") == "M862.1 P0.4");
  CHECK(sanitise("\r\nG1 X1\rG1 X2") == "G1 X1");
  for (int c = 0; c < 256; ++c) {
    const std::string clean = sanitise(std::string("M117 x") + static_cast<char>(c) + "y");
    CHECK(is_clean(clean));
    CHECK(sanitise(clean) == clean);
  }
}

TEST_CASE("bytes become lines wherever they are cut", "[codec]") {
  const std::string stream = "start\r\n\n  \necho: a\nok\nT:1";
  for (std::size_t cut = 0; cut <= stream.size(); ++cut) {
    LineSplitter splitter;
    std::vector<std::string> lines;
    std::string line;
    splitter.feed(std::string_view(stream).substr(0, cut));
    while (splitter.next(line)) lines.push_back(line);
    splitter.feed(std::string_view(stream).substr(cut));
    while (splitter.next(line)) lines.push_back(line);
    CHECK(lines == std::vector<std::string>{"start", "echo: a", "ok"});
  }
}

TEST_CASE("noise without a line end is not kept for ever", "[codec]") {
  LineSplitter splitter;
  std::string line;
  for (int i = 0; i < 100; ++i) {
    splitter.feed(std::string(1000, 'x'));
    CHECK_FALSE(splitter.next(line));
  }
  splitter.feed("\nok\n");
  std::vector<std::string> lines;
  while (splitter.next(line)) lines.push_back(line);
  REQUIRE(!lines.empty());
  CHECK(lines.back() == "ok");
  CHECK(lines.front().size() <= 5000);
}

TEST_CASE("zero bytes vanish from a reply", "[codec]") {
  LineSplitter splitter;
  splitter.feed(std::string_view("o\0k\0\n", 5));
  std::string line;
  REQUIRE(splitter.next(line));
  CHECK(line == "ok");
}
