#include "engine/gcode/estimate.h"

#include "tests/engine/motion/recorder.h"

#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

using namespace voidpath;
using gcode::Estimate;

namespace {

Estimate timed(const std::string& text, motion::MachineLimits limits = test::plain_limits()) {
  std::istringstream in(text);
  return gcode::estimate(in, limits);
}

/// Waiting for company at a first move that stays alone; see Planner.
constexpr double kFirstWait_s = 0.1;

}  // namespace

TEST_CASE("a travel is timed by its trapezoid", "[gcode]") {
  // 100 mm at 3000 mm/min = 50 mm/s, 1000 mm/s²: 100/50 + 50/1000 = 2.05 s.
  const Estimate out = timed("G1 X100 F3000\n");
  CHECK(out.predicted_s == Approx(2.05 + kFirstWait_s).margin(0.002));
  CHECK(out.travel_s == Approx(2.05).epsilon(1e-3));
  CHECK(out.travel_mm == Approx(100));
  CHECK(out.moves == 1);
  CHECK(out.lines == 1);
  CHECK(out.limits_from == "profile");
}

TEST_CASE("absolute, relative, inch and renamed positions mean the same print", "[gcode]") {
  const double expected = timed("G1 X25.4 E2 F600\nG1 X50.8 E4\nG1 Y25.4 E6\n").predicted_s;
  for (const char* text : {"G91\nG1 X25.4 E2 F600\nG1 X25.4 E2\nG1 Y25.4 E2\n",
                           "M83\nG1 X25.4 E2 F600\nG1 X50.8 E2\nG1 Y25.4 E2\n",
                           "G1 X25.4 E2 F600\nG92 E0\nG1 X50.8 E2\nG92 E0\nG1 Y25.4 E2\n",
                           "G20\nG1 X1 E.0787401575 F23.6220472\nG1 X2 E.157480315\nG1 Y1 E.236220472\n",
                           "G91\nM82\nG1 X25.4 E2 F600\nG1 X25.4 E4\nG1 Y25.4 E6\n"}) {
    INFO(text);
    // The queue slot of G92 and the last digit of inches may move a start by a poll of 1 ms.
    CHECK(timed(text).predicted_s == Approx(expected).margin(0.003));
  }
}

TEST_CASE("dwells and full stops", "[gcode]") {
  // Two times 50 mm at 50 mm/s: one pass 100/50 + 0.05; with a stop between 2·(50/50 + 0.05).
  const double through = timed("G1 X50 F3000\nG1 X100\nG1 X150\n").travel_s;
  CHECK(through == Approx(3.05).epsilon(1e-3));
  CHECK(timed("G1 X50 F3000\nM400\nG1 X100\nM400\nG1 X150\n").travel_s == Approx(3.15).epsilon(1e-3));
  const Estimate dwell = timed("G1 X50 F3000\nG4 P1500\nG1 X100\nG4 S2\nG1 X150\n");
  CHECK(dwell.dwell_s == Approx(3.5));
  CHECK(dwell.predicted_s == Approx(3.15 + 3.5 + 3 * kFirstWait_s).margin(0.01));
  for (const char* word : {"M105", "M114", "M73 P5", "M117 hello", "M220 S100", "M204 P1000", "M106 S255"}) {
    INFO(word);
    CHECK(timed(std::string("G1 X50 F3000\nG1 X100\n") + word + "\nG1 X150\n").travel_s ==
          Approx(through).epsilon(1e-6));
  }
}

TEST_CASE("M220 and M221 scale speed and filament", "[gcode]") {
  CHECK(timed("M220 S50\nG1 X100 F3000\n").travel_s == Approx(100 / 25.0 + 0.025).epsilon(1e-3));
  CHECK(timed("M221 S50\nM83\nG1 E10 F600\n").retract_s == Approx(5 / 10.0 + 0.01).epsilon(1e-3));
}

TEST_CASE("limits in the G-code replace the profile's", "[gcode]") {
  CHECK(timed("M203 X20\nG1 X100 F3000\n").travel_s == Approx(100 / 20.0 + 0.02).epsilon(1e-3));
  CHECK(timed("M201 X100\nG1 X100 F3000\n").travel_s == Approx(2 + 0.5).epsilon(1e-3));
  CHECK(timed("M204 T200\nG1 X100 F3000\n").travel_s == Approx(2 + 0.25).epsilon(1e-3));
  CHECK(timed("M204 S200\nG1 X100 F3000\n").travel_s == Approx(2 + 0.25).epsilon(1e-3));
  CHECK(timed("M204 P200\nG1 X100 F3000\n").travel_s == Approx(2.05).epsilon(1e-3));
  CHECK(timed("M201 X100\nG1 X100 F3000\n").limits_from == "G-code");
  CHECK(timed("M92 X100\nG1 X100 F3000\n").limits_from == "profile");

  const std::string corner = "\nG1 X50 F3000\nG1 Y50\nG1 X0\nG1 Y0\n";
  const double plain = timed(corner).travel_s;
  CHECK(timed("M205 X20 Y20" + corner).travel_s == Approx(plain));  // a junction-deviation firmware
  CHECK(timed("M205 J0.2" + corner).travel_s < plain - 0.01);
  CHECK(timed("M205 J0.5" + corner).travel_s == Approx(plain));  // out of range: refused
  motion::MachineLimits jerky = test::plain_limits();
  jerky.jerk_mm_s = motion::PerAxis{8, 8, 0.4, 5};
  CHECK(timed("M205 X20 Y20" + corner, jerky).travel_s < timed(corner, jerky).travel_s - 0.01);
}

TEST_CASE("arcs are as long as they are round", "[gcode]") {
  // Half circle of radius 20: 62.83 mm at 20 mm/s, acceleration room to spare: 3.1416 s + 0.02.
  for (const char* arc : {"G3 X0 Y40 I0 J20 F1200\n", "G3 X0 Y40 R20 F1200\n"}) {
    const Estimate out = timed(std::string("G1 X0 Y0.01 F1200\nG1 Y0\n") + arc);
    CHECK(out.travel_mm == Approx(62.83).epsilon(2e-3));
    CHECK(out.travel_s == Approx(62.83 / 20 + 0.02).epsilon(0.02));
  }
  CHECK(timed("G2 X10 F1200\n").moves == 0);  // no centre: refused
}

TEST_CASE("homing before the first move is not part of the print, later it is", "[gcode]") {
  const Estimate before = timed("G28\nG1 X100 F3000\n");
  CHECK(before.homing_s > 5);
  CHECK(before.predicted_s == Approx(2.05 + kFirstWait_s).margin(0.002));
  const Estimate after = timed("G1 X100 F3000\nG28 X\n");
  CHECK(after.homing_s > 0);
  CHECK(after.predicted_s == Approx(2.05 + kFirstWait_s + after.homing_s).margin(0.002));
}

TEST_CASE("what comes after heating is told apart", "[gcode]") {
  const std::string start = "G28\nM140 S60\nG1 Z5 F600\nM190 S60\nG1 X50 F3000\nM109 S210\n";
  const std::string print = "G1 X60 E1 F1200\nG1 X120 E4\nM104 S205\n";
  const Estimate out = timed(start + print);
  // The Z lift (5/10 + 0.01) and the travel (50/50 + 0.05) come before M109.
  CHECK(out.predicted_s - out.after_heating_s == Approx(0.51 + 1.05 + 2 * kFirstWait_s).margin(0.01));
  CHECK(timed(print).after_heating_s == timed(print).predicted_s);
  // A wait in mid-print (a change of filament, say) is not the start.
  CHECK(timed(start + print + "M109 S230\nG1 X200 F3000\n").after_heating_s > out.after_heating_s + 1);
}

TEST_CASE("features, layers, filament and retractions", "[gcode]") {
  const Estimate out = timed(
      "M83\n;LAYER_CHANGE\n;Z:0.3\nG1 Z0.3 F600\n;TYPE:Perimeter\nG1 X10 E1 F1200\nG1 Y10 E1\n"
      "G1 X9 E-.5\nG1 E-.5 F2400\nG1 X40 F6000\nG1 E1 F2400\n"
      ";TYPE:Internal infill\nG1 X80 E2 F1200\n;LAYER_CHANGE\n;Z:0.5\nG1 Z0.5 F600\nG1 X40 E2 F1200\nG1 E-1 "
      "F2400\n");
  REQUIRE(out.layers.size() == 2);
  CHECK(out.layers[0].z_mm == Approx(0.3));
  CHECK(out.layers[1].z_mm == Approx(0.5));
  CHECK(out.layers[0].first_line == 1);
  CHECK(out.layers[1].first_line == 13);
  CHECK(out.retractions == 2);  // wiping while drawing back, then drawing back, is one
  CHECK(out.filament_mm == Approx(6));
  CHECK(out.extruding_mm == Approx(10 + 10 + 40 + 40));
  REQUIRE(out.by_feature.size() == 2);
  // 40 mm at 20 mm/s twice, roughly; ramps and corners on top.
  CHECK(out.by_feature.at("Internal infill") == Approx(4.06).epsilon(0.02));
  CHECK(out.by_feature.at("Perimeter") + out.by_feature.at("Internal infill") == Approx(out.extruding_s));
  CHECK(out.extruding_s + out.travel_s + out.retract_s == Approx(out.predicted_s).margin(0.002));
  CHECK(out.layers[0].seconds + out.layers[1].seconds == Approx(out.predicted_s).margin(0.002));
}

TEST_CASE("Cura's layers take their height from the first extrusion", "[gcode]") {
  const Estimate out = timed(
      "G1 Z2\nG1 X5 E1 F1200\n;LAYER_COUNT:2\n;LAYER:0\nG1 Z.2\nG1 X9 E2\n;LAYER:1\nG1 Z.4\nG1 X0 E3\n");
  REQUIRE(out.layers.size() == 2);  // what was guessed before the first remark is gone
  CHECK(out.layers[0].z_mm == Approx(0.2));
  CHECK(out.layers[1].z_mm == Approx(0.4));
}

TEST_CASE("without remarks layers are the heights at which it extrudes", "[gcode]") {
  const Estimate out =
      timed("M83\nG1 Z.2 F600\nG1 X9 E2\nG1 Z.6\nG1 X0\nG1 Z.2\nG1 X5 E1\nG1 Z.4\nG1 X0 E3\n");
  REQUIRE(out.layers.size() == 2);
  CHECK(out.layers[1].z_mm == Approx(0.4));
  CHECK(out.by_feature.empty());
}

TEST_CASE("firmware retraction moves filament behind the file's back", "[gcode]") {
  const Estimate out = timed("M207 S2 F1200\nG1 X10 E1 F1200\nG10\nG1 X20\nG11\nG1 X30 E2\n");
  CHECK(out.retractions == 1);
  CHECK(out.filament_mm == Approx(2));
  CHECK(out.retract_s > 2 * 2 / 20.0);
}

TEST_CASE("each line's motion is told as it becomes final", "[gcode]") {
  std::istringstream in(";head\nG1 X10 F3000\n\nG1 X10.0005\nG1 X60\nG4 S1\nG2 X70 R5\n");
  std::vector<std::size_t> lines;
  double last_s = 0;
  const Estimate out =
      gcode::estimate(in, test::plain_limits(), {}, [&](std::size_t line, double begin_s, double end_s) {
        CHECK(begin_s >= last_s);
        CHECK(end_s > begin_s);
        if (lines.empty() || lines.back() != line) lines.push_back(line);
        last_s = end_s;
      });
  CHECK(lines == std::vector<std::size_t>{1, 4, 6});  // line 3 asks for half a step
  CHECK(last_s == Approx(out.predicted_s));
}

TEST_CASE("a slow line is said to be the brake", "[gcode]") {
  std::string text = "M83\nG1 F6000\n";
  for (int i = 1; i <= 3000; ++i) text += "G1 X" + std::to_string(i * 0.05) + " E.0021\n";
  motion::MachineLimits limits = test::plain_limits();
  const double fast = timed(text, limits).predicted_s;
  limits.baud = 19200;
  const Estimate slow = timed(text, limits);
  CHECK(slow.predicted_s > 2 * fast);
  CHECK(slow.serial_limited_s == Approx(slow.predicted_s - fast).margin(1e-6));
}

TEST_CASE("machine.stepping chooses how a block is stepped", "[gcode]") {
  std::string zigzag = "G1 F6000\n";
  for (int i = 1; i <= 200; ++i)
    zigzag += "G1 X" + std::to_string(4 * i) + " Y" + std::to_string(i % 2 * 4) + "\n";
  const auto by = [&](motion::Stepping stepping) {
    motion::MachineLimits limits = test::plain_limits();
    limits.stepping = stepping;
    limits.steps_per_mm = {80, 80, 400, 93};
    limits.max_acceleration_mm_s2 = {1500, 1500, 100, 5000};
    return timed(zigzag, limits).predicted_s;
  };
  const double early = by(motion::Stepping::marlin_2_0);
  const double ideal = by(motion::Stepping::ideal);
  const double reworked = by(motion::Stepping::marlin_2_1_3);
  // Deceleration that ends early is some percent faster than the trapezoid it was meant to be.
  CHECK(early < 0.99 * ideal);
  CHECK(early > 0.9 * ideal);
  CHECK(reworked == Approx(ideal).epsilon(0.005));
}

TEST_CASE("a file's own limits and percentages count from where they stand", "[gcode]") {
  const std::string move = "G1 X100 F6000\n";
  const double usual = timed(move + "G1 X0\n").predicted_s;
  CHECK(timed("M201 X200\n" + move + "G1 X0\n").predicted_s > usual + 0.3);
  CHECK(timed("M204 T200\n" + move + "G1 X0\n").predicted_s > usual + 0.3);
  CHECK(timed("M203 X20\n" + move + "G1 X0\n").predicted_s > 10);
  CHECK(timed(move + "M203 X20\nG1 X0\n").predicted_s < 10);  // the first was on its way
  CHECK(timed("M220 S50\n" + move + "G1 X0\n").predicted_s > usual + 1.5);
  CHECK(timed("M204 P1\n" + move + "G1 X0\n").predicted_s == Approx(usual));  // no print move there
  CHECK(timed("M201 X200\n" + move).limits_from == "G-code");
}

TEST_CASE("PrusaSlicer's, Cura's and our own remarks sort time alike", "[gcode]") {
  const auto print = [](const std::string& layer, const std::string& wall, const std::string& fill) {
    return "M83\nG1 Z0.2 F600\n" + layer + ";TYPE:" + wall + "\nG1 X20 E1 F1200\nG1 Y20 E1\n;TYPE:" + fill +
           "\nG1 X0 Y0 E1 F2400\n";
  };
  const Estimate prusa =
      timed(print(";LAYER_CHANGE\n;Z:0.2\n;HEIGHT:0.2\n", "External perimeter", "Internal infill"));
  const Estimate cura = timed(print(";LAYER:0\n", "WALL-OUTER", "FILL"));
  REQUIRE(prusa.by_feature.size() == 2);
  REQUIRE(cura.by_feature.size() == 2);
  CHECK(prusa.by_feature.at("External perimeter") == Approx(cura.by_feature.at("WALL-OUTER")));
  CHECK(prusa.by_feature.at("Internal infill") == Approx(cura.by_feature.at("FILL")));
  CHECK(prusa.by_feature.at("External perimeter") + prusa.by_feature.at("Internal infill") ==
        Approx(prusa.extruding_s));
  CHECK(prusa.layers.size() == cura.layers.size());
}

TEST_CASE("a stop is obeyed and progress told", "[gcode]") {
  std::string text;
  for (int i = 0; i < 20000; ++i) text += "G1 X" + std::to_string(i % 100) + "\n";
  std::stop_source source;
  source.request_stop();
  run::Context ctx;
  ctx.stop = source.get_token();
  std::istringstream in(text);
  CHECK_THROWS_AS(gcode::estimate(in, {}, ctx), run::Stopped);
}

TEST_CASE("files that are no G-code are refused by name", "[gcode]") {
  const auto file = std::filesystem::temp_directory_path() / "voidpath_estimate_test.gcode";
  const auto write = [&](const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; };
  const auto refused = [&] { return Catch::Contains("voidpath_estimate_test.gcode"); };
  write("GCDE\x01\x02");
  CHECK_THROWS_WITH(gcode::estimate_file(file, {}), refused());
  write(std::string("G1 X1\n\0\0", 8));
  CHECK_THROWS_WITH(gcode::estimate_file(file, {}), refused());
  write("dear diary\n");
  CHECK_THROWS_WITH(gcode::estimate_file(file, {}), refused());
  write("; nothing but this\nG1 X100 F3000\n");
  CHECK(gcode::estimate_file(file, test::plain_limits()).moves == 1);
  std::filesystem::remove(file);
  CHECK_THROWS_WITH(gcode::estimate_file(file, {}), refused());
}

TEST_CASE("any bytes give a finite estimate", "[gcode]") {
  std::mt19937 random(5);
  const std::string alphabet = "GGGG0123456789MXYZEFSPIJR.-  \n\n\n;:\xff";
  const std::string heads[] = {"G1 ",   "G2 ",  "G3 ", "G92 ",  "M204 ",   "M205 ",
                               "M203 ", "M92 ", "G4 ", "M220 ", ";LAYER:", ";TYPE:"};
  for (int round = 0; round < 300; ++round) {
    std::string text;
    for (int line = 0; line < 60; ++line) {
      text += heads[random() % std::size(heads)];
      for (auto i = random() % 24; i > 0; --i) text += alphabet[random() % alphabet.size()];
      text += '\n';
    }
    motion::MachineLimits limits;
    if (round % 2 == 0) limits.jerk_mm_s = motion::PerAxis{8, 8, 0.4, 5};
    const Estimate out = timed(text, limits);
    CHECK(out.predicted_s >= 0);
    CHECK(out.predicted_s < std::numeric_limits<double>::infinity());
  }
}
