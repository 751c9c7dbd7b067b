#include "firmware-io/clock.h"
#include "firmware-io/flight_recorder.h"
#include "firmware-io/marlin/codec.h"
#include "firmware-io/marlin/file_command.h"
#include "firmware-io/marlin/words.h"
#include "firmware-io/printer_port.h"

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using marlin::file_command;

namespace {

/// A file in the temporary folder that goes with its owner.
class ScratchFile {
 public:
  explicit ScratchFile(const std::string& content) {
    std::string pattern = (std::filesystem::temp_directory_path() / "voidpath-test-XXXXXX").string();
    const int fd = ::mkstemp(pattern.data());
    REQUIRE(fd >= 0);
    path = pattern;
    std::ofstream(path, std::ios::binary) << content;
  }
  ~ScratchFile() { std::filesystem::remove(path); }
  std::string path;
};

}  // namespace

TEST_CASE("a file's commands come in order with their line numbers", "[gcode_file]") {
  const ScratchFile file(
      "; made by hand\nG28 ; home\n\n  \nG1 X1.5 Y2 E0.1\r\n;LAYER_CHANGE\nM117 hi (you)\nM84");
  const auto source = open_gcode_file(file.path);
  std::vector<std::pair<std::uint32_t, std::string>> lines;
  std::uint64_t before = 0;
  while (const auto line = source->next()) {
    lines.emplace_back(line->index, line->text);
    CHECK(source->position() > before);
    before = source->position();
  }
  CHECK(lines == decltype(lines){{1, "G28"}, {4, "G1 X1.5 Y2 E.1"}, {6, "M117 hi you"}, {7, "M84"}});
  CHECK(source->position() == source->size());
  CHECK(source->size() == std::filesystem::file_size(file.path));
}

TEST_CASE("a carriage return amid a line divides two commands of one line number", "[gcode_file]") {
  const ScratchFile file("G28\r\nG1 X1\rG1 X2\r\r\n\rM84");
  const auto source = open_gcode_file(file.path);
  std::vector<std::pair<std::uint32_t, std::string>> lines;
  while (const auto line = source->next()) lines.emplace_back(line->index, line->text);
  CHECK(lines == decltype(lines){{0, "G28"}, {1, "G1 X1"}, {1, "G1 X2"}, {2, "M84"}});
}

TEST_CASE("an unusable file is named with its line", "[gcode_file]") {
  CHECK_THROWS_WITH(open_gcode_file("/nowhere/x.gcode"), Catch::Contains("/nowhere/x.gcode"));
  const ScratchFile binary(std::string("G28\nG1 X1\0Y", 11));
  const auto source = open_gcode_file(binary.path);
  CHECK(source->next()->text == "G28");
  CHECK_THROWS_WITH(source->next(), Catch::Contains(binary.path + ":2:"));
  const ScratchFile long_line("G28\nM862.3 P\"" + std::string(200, 'x') + "\"\n");
  const auto other = open_gcode_file(long_line.path);
  other->next();
  CHECK_THROWS_WITH(other->next(), Catch::Contains(":2:"));
}

TEST_CASE("commands are brought into the form a printer takes", "[gcode_file]") {
  CHECK(file_command("g1 x1 y-2.5 e.3") == "G1 X1 Y-2.5 E.3");
  CHECK(file_command("m117 Hello, World") == "M117 Hello, World");
  CHECK(file_command("t1") == "T1");
  CHECK(file_command("N12 G1 X1*99") == "G1 X1");
  CHECK(file_command("N12G1 X1") == "G1 X1");
  CHECK(file_command("G1 X10*87") == "G1 X10");
  CHECK(file_command("N12 G1 X10*87 ; 3*4") == "G1 X10");
  CHECK(file_command("M110 N0").empty());
  CHECK(file_command("N0 M110*5").empty());
  CHECK(file_command("M117 of M110 N7").empty());
  CHECK(file_command("G1 X1 M1 10").empty());
  CHECK(file_command("%").empty());
  CHECK(file_command("@pause").empty());
  CHECK(file_command("(a comment)").empty());
  const std::string exact = "G1 X1.123456789 Y2";
  CHECK(file_command(exact) == exact);
  const std::string precise = file_command(
      "G2 X123.1234567890123 Y123.1234567890123 I12.1234567890123 J12.1234567890123 E1.1234567890123 F1200");
  CHECK(precise == "G2 X123.12345 Y123.12345 I12.12345 J12.12345 E1.12345 F1200");
  CHECK(file_command("M117 " + std::string(200, 'a')).size() == marlin::kMaxPayload);
}

TEST_CASE("what streaming must know of a command", "[words]") {
  using namespace marlin;
  CHECK(first_word("G28.1 X") == Word{'G', 28});
  CHECK(first_word("m104 S0") == Word{'M', 104});
  CHECK(first_word("") == Word{});
  CHECK(is_heating_wait("M109 S200"));
  CHECK(is_heating_wait("M190 R60"));
  CHECK_FALSE(is_heating_wait("M104 S200"));
  CHECK_FALSE(is_heating_wait("M1090"));
  CHECK(is_motion("G1 X1"));
  CHECK(is_motion("G0Z5"));
  CHECK(is_motion("G2 I1 J1"));
  CHECK(is_motion("G1 E-2 F1800"));
  CHECK_FALSE(is_motion("G1 F1800"));
  CHECK_FALSE(is_motion("G28 X"));
  CHECK_FALSE(is_motion("G92 E0"));
  CHECK(is_long("G29"));
  CHECK(is_long("M400"));
  CHECK_FALSE(is_long("G1 X1"));
  CHECK(is_pause("M0"));
  CHECK(is_pause("M1 S5"));
  CHECK_FALSE(is_pause("M104"));
  CHECK(is_out_of_band("M108"));
}

TEST_CASE("a published clock is read as it moves", "[clock]") {
  std::string content("VPCLOCK1");
  double seconds = 12.5;
  content.append(reinterpret_cast<const char*>(&seconds), sizeof seconds);
  const ScratchFile file(content);
  const auto clock = mapped_clock(file.path);
  CHECK(clock->now_s() == 12.5);
  seconds = 99.25;
  std::fstream out(file.path, std::ios::in | std::ios::out | std::ios::binary);
  out.seekp(8).write(reinterpret_cast<const char*>(&seconds), sizeof seconds).flush();
  CHECK(clock->now_s() == 99.25);
}

TEST_CASE("what is no clock is refused by name", "[clock]") {
  const ScratchFile wrong(std::string(16, 'x'));
  CHECK_THROWS_WITH(mapped_clock(wrong.path), Catch::Contains(wrong.path));
  const ScratchFile tiny("VPCLOCK1");
  CHECK_THROWS_WITH(mapped_clock(tiny.path), Catch::Contains(tiny.path));
  CHECK_THROWS_WITH(mapped_clock("/nowhere/clock"), Catch::Contains("/nowhere/clock"));
}

TEST_CASE("the steady clock does not go back", "[clock]") {
  const auto clock = steady_clock();
  const double before = clock->now_s();
  CHECK(clock->now_s() >= before);
}

TEST_CASE("the recorder keeps the last lines each way, in order", "[flight_recorder]") {
  FlightRecorder recorder(3);
  for (int i = 0; i < 10; ++i) {
    recorder.sent(i, "G1 X" + std::to_string(i) + "\n");
    if (i % 5 == 0) recorder.received(i + 0.5, "ok");
  }
  CHECK(recorder.lines() == std::vector<std::string>{"0.500 < ok", "5.500 < ok", "7.000 > G1 X7",
                                                     "8.000 > G1 X8", "9.000 > G1 X9"});
}

TEST_CASE("a move is written in fewer bytes", "[gcode_file]") {
  CHECK(marlin::trim_move("G1 X010.500 Y-0.250  Z+3.000 E0.12300 F1800.0", true) ==
        "G1 X10.5 Y-.25 Z3 E.123 F1800");
  CHECK(marlin::trim_move("G1 X1.2345 Y9.9996 Z-0.0004 E1.234567", true) == "G1 X1.235 Y10 Z0 E1.234567");
  CHECK(marlin::trim_move("G1 X1.2345 Y-0.000 Z5.", false) == "G1 X1.2345 Y0 Z5");
  CHECK(marlin::trim_move("G2 X1.00 I0.12345 J-0.50000", true) == "G2 X1 I.12345 J-.5");
  // A place rounded by half a micrometre moves the middle of a half circle by a hundred times as much.
  CHECK(marlin::trim_move("G2 X10.00040 Y0.00 R5.0002", true) == "G2 X10.0004 Y0 R5.0002");
  CHECK(marlin::trim_move("G3 X0.00 Y0.0004 I5.0 J0.0", true) == "G3 X0 Y.0004 I5 J0");
  for (const char* other : {"M117 X1.500 0.50", "G92 E0.000", "G29 P1.0", "G1 X Y", "G1 X1.2.3", "G1 X1-2",
                            "G1 X1 \"a 0.50\"", "G1 X."})
    CHECK(marlin::trim_move(other, true) == other);
}

TEST_CASE("a shortened move goes where it went", "[gcode_file]") {
  const auto values = [](const std::string& line) {
    std::map<char, double> out;
    for (std::size_t i = 0; i + 1 < line.size(); ++i)
      if (line[i] >= 'A' && line[i] <= 'Z') out[line[i]] = std::strtod(line.c_str() + i + 1, nullptr);
    return out;
  };
  std::mt19937 random(7);
  const auto number = [&] {
    std::string text = random() % 3 == 0 ? "-" : "";
    for (auto n = random() % 4; n > 0; --n) text += static_cast<char>('0' + random() % 10);
    if (text.empty() || text == "-") text += '0';
    if (random() % 4 == 0) return text;
    text += '.';
    for (auto n = random() % 7; n > 0; --n)
      text += random() % 2 == 0 ? '9' : static_cast<char>('0' + random() % 10);
    return text;
  };
  for (int i = 0; i < 20000; ++i) {
    const std::string line =
        "G1 X" + number() + " Y" + number() + " Z" + number() + " E" + number() + " F" + number();
    const bool absolute = i % 2 == 0;
    const std::string shorter = marlin::trim_move(line, absolute);
    CAPTURE(line, shorter);
    REQUIRE(shorter.size() <= line.size());
    const auto before = values(line), after = values(shorter);
    REQUIRE(before.size() == after.size());
    for (const auto& [letter, value] : before) {
      const bool place = letter >= 'X' && letter <= 'Z';
      REQUIRE(std::abs(after.at(letter) - value) <= (absolute && place ? 0.0005000001 : 0));
    }
    REQUIRE(marlin::trim_move(shorter, absolute) == shorter);
  }
}

TEST_CASE("places are rounded where nothing can add up", "[gcode_file]") {
  const ScratchFile file("G1 X1.00049\nG90\nG1 X1.00049\nG20\nG1 X1.00049\nG21\nG91\nG1 X1.00049\n");
  const auto source = open_gcode_file(file.path);
  std::vector<std::string> moves;
  while (const auto line = source->next())
    if (line->text.starts_with("G1")) moves.push_back(line->text);
  CHECK(moves == std::vector<std::string>{"G1 X1.00049", "G1 X1", "G1 X1.00049", "G1 X1.00049"});
}

TEST_CASE("an arc begins where it was meant to, and from then on nothing is rounded", "[gcode_file]") {
  const auto read = [](const std::string& text) {
    const ScratchFile file(text);
    const auto source = open_gcode_file(file.path);
    std::vector<std::string> lines;
    while (const auto line = source->next()) lines.push_back(line->text);
    return lines;
  };
  using Lines = std::vector<std::string>;
  CHECK(read("G90\nG1 X10.0004 Y7.00004\nG1 Z1.00004\nG1 E1\nG2 X10.0004 I5\nG1 X1.00049\nG2 X9 I1\n") ==
        Lines{"G90", "G1 X10 Y7", "G1 Z1", "G1 E1", "G1 X10.0004 Y7.00004", "G2 X10.0004 I5", "G1 X1.00049",
              "G2 X9 I1"});
  // Where the last of them was exact, there is nothing to mend.
  CHECK(read("G90\nG1 X10.0004 Y7.00004\nG1 X3 Y4\nG2 X3 I5\n") ==
        Lines{"G90", "G1 X10 Y7", "G1 X3 Y4", "G2 X3 I5"});
  CHECK(read("G90\nG1 X10.0004 Y7.00004\nG1 X3\nG3 X3 I5\n") ==
        Lines{"G90", "G1 X10 Y7", "G1 X3", "G1 Y7.00004", "G3 X3 I5"});
  for (const char* still : {"G92 E0", "G17"})
    CHECK(read("G90\nG1 X10.0004\n" + std::string(still) + "\nG2 X10.0004 I5\n") ==
          Lines{"G90", "G1 X10", still, "G1 X10.0004", "G2 X10.0004 I5"});
  // A place of another name by now.
  for (const char* moved : {"G92 X0 Y0", "G92 E0 X0", "G92.1", "G28", "G91"})
    CHECK(read("G90\nG1 X10.0004\n" + std::string(moved) + "\nG2 X1 I5\n") ==
          Lines{"G90", "G1 X10", moved, "G2 X1 I5"});
}
