#include "engine/gcode/reader.h"

#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

using namespace voidpath::gcode;

TEST_CASE("a line is cut into code and comment", "[gcode]") {
  CHECK(split_line("G1 X1 ; note").code == "G1 X1");
  CHECK(split_line("G1 X1 ; note").comment == " note");
  CHECK(split_line("  N12 G1 X1*34 ").code == "G1 X1");
  CHECK(split_line("N12G1X1*34;c*5").code == "G1X1");
  CHECK(split_line(";TYPE:Skirt").code.empty());
  CHECK(split_line(";TYPE:Skirt").comment == "TYPE:Skirt");
  CHECK(split_line("").code.empty());
  CHECK(split_line("M117 5*3=15").code == "M117 5*3=15");  // no line number: no checksum
}

TEST_CASE("words may stand together, apart, lower-case and without number", "[gcode]") {
  for (const char* text :
       {"G1 X10.5 Y-.25 E1e5", "G1X10.5Y-.25E1E5", "g1 x 10.5 y -.25 e1e5", "(a) G1 (b) X10.5 Y-.25 E1 E5"}) {
    const Command command = parse_command(text);
    INFO(text);
    CHECK(command.is('G', 1));
    CHECK(command.get('X') == 10.5F);
    CHECK(command.get('Y') == -0.25F);
    CHECK(command.get('E') == 5);  // no exponents: a second E word
    CHECK_FALSE(command.has('Z'));
  }
  const Command home = parse_command("G28 X Y");
  CHECK(home.has('X'));
  CHECK(home.has_any("YZ"));
  CHECK_FALSE(home.has_any("Z"));
  CHECK(parse_command("G92.1").subcode == 1);
  CHECK(parse_command("M204 S+500").get('S') == 500);
  CHECK(parse_command("T0").is('T', 0));
}

TEST_CASE("what is no command is none", "[gcode]") {
  for (const char* text : {"", "G", "1 2 3", "Gx", "%", "G99999999999", "@begin", "\x80\xff", "-G1"}) {
    INFO(text);
    CHECK(parse_command(text).letter == 0);
  }
}

TEST_CASE("numbers no machine could mean are not seen", "[gcode]") {
  const Command command = parse_command("G1 X1" + std::string(60, '0') + " Ynan Zinf F1200");
  CHECK_FALSE(command.has('X'));
  CHECK(command.get('F') == 1200);
}

TEST_CASE("lines come whole across the pieces of a large stream", "[gcode]") {
  std::string text;
  std::vector<std::string> expected;
  for (int i = 0; i < 60000; ++i) {
    expected.push_back("G1 X" + std::to_string(i) + std::string(static_cast<std::size_t>(i % 17), ' '));
    text += expected.back() + (i % 3 == 0 ? "\r\n" : "\n");
  }
  text += "M400";  // no newline at the end
  expected.push_back("M400");
  std::istringstream in(text);
  LineReader reader(in);
  std::string_view line;
  std::size_t n = 0;
  bool same = true;
  while (reader.next(line)) same = same && n < expected.size() && line == expected[n++];
  CHECK(same);
  CHECK(n == expected.size());
  CHECK(reader.bytes_read() == text.size());
}

TEST_CASE("an endless line is cut short and the next one is whole", "[gcode]") {
  std::istringstream in("first\n" + std::string(3'000'000, 'x') + "\nlast\n");
  LineReader reader(in);
  std::string_view line;
  REQUIRE(reader.next(line));
  CHECK(line == "first");
  REQUIRE(reader.next(line));
  CHECK(line.size() == LineReader::kMaxLine);
  REQUIRE(reader.next(line));
  CHECK(line == "last");
  CHECK_FALSE(reader.next(line));
}

TEST_CASE("any bytes are read without harm", "[gcode]") {
  std::mt19937 random(11);
  const std::string alphabet = "GMTXYZEFSPIJKRN0123456789.-+*; ()\n\r\t\0\xff%e";
  std::size_t commands = 0;
  for (int round = 0; round < 2000; ++round) {
    std::string text;
    for (auto i = random() % 200; i > 0; --i) text += alphabet[random() % alphabet.size()];
    const Line line = split_line(text);
    const Command command = parse_command(line.code);
    commands += command.letter != 0 ? 1 : 0;
    for (const float value : command.values) CHECK(value == value);
  }
  CHECK(commands > 0);
}
