#include "firmware-io/marlin/settings.h"

#include <string>
#include <string_view>

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using voidpath::fw::marlin::SettingsReader;

namespace {

std::optional<FirmwareLimits> read(std::string_view text) {
  SettingsReader reader;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    reader.take(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return reader.limits();
}

PerAxis axes(double x, double y, double z, double e) { return {x, y, z, e}; }

}  // namespace

TEST_CASE("the settings of a Marlin 2 with classic jerk", "[settings]") {
  const auto limits = read(
      "echo:; Linear Units:\necho:  G21 ; (mm)\necho:; Steps per unit:\n"
      "echo:  M92 X80.00 Y80.00 Z400.00 E93.00\necho:; Max feedrates (units/s):\n"
      "echo:  M203 X500.00 Y500.00 Z5.00 E25.00\necho:; Max Acceleration (units/s2):\n"
      "echo:  M201 X500.00 Y500.00 Z100.00 E5000.00\n"
      "echo:; Acceleration (units/s2) (P<print-accel> R<retract-accel> T<travel-accel>):\n"
      "echo:  M204 P500.00 R1000.00 T700.00\n"
      "echo:; Advanced (B<min_segment_time_us> S<min_feedrate> T<min_travel_feedrate> X<max_jerk>):\n"
      "echo:  M205 B20000.00 S1.00 T2.00 X10.00 Y10.00 Z0.30 E5.00\n"
      "echo:; Home offset:\necho:  M206 X0.00 Y0.00 Z0.00\n"
      "echo:  M211 S1 ; ON\necho:  Min:  X-5.00 Y0.00 Z0.00   Max:  X235.00 Y232.00 Z283.00\n");
  REQUIRE(limits);
  CHECK(limits->steps_per_mm == axes(80, 80, 400, 93));
  CHECK(limits->max_feed_mm_s == axes(500, 500, 5, 25));
  CHECK(limits->max_acceleration_mm_s2 == axes(500, 500, 100, 5000));
  CHECK(limits->jerk_mm_s == axes(10, 10, 0.3, 5));
  CHECK_FALSE(limits->junction_deviation_mm);
  CHECK(limits->print_acceleration_mm_s2 == 500.0);
  CHECK(limits->retract_acceleration_mm_s2 == 1000.0);
  CHECK(limits->travel_acceleration_mm_s2 == 700.0);
  CHECK(limits->min_feed_mm_s == 1.0);
  CHECK(limits->min_travel_feed_mm_s == 2.0);
  CHECK(limits->min_segment_time_s.value() == Approx(0.02));
  REQUIRE(limits->volume);
  CHECK(*limits->volume == MachineBox{{-5, 0, 0}, {235, 232, 283}});
}

TEST_CASE("junction deviation, several extruders and the area of M115", "[settings]") {
  const auto limits = read(
      "area:{full:{min:{x:0.0000,y:1.0000,z:0.0000},max:{x:220.0000,y:221.0000,z:250.0000},},"
      "work:{min:{x:5.0000,y:5.0000,z:0.0000},max:{x:200.0000,y:200.0000,z:250.0000},},}\n"
      "echo: M92 X80.00 Y80.00 Z400.00\necho: M92 T0 E411.75\necho: M92 T1 E93.45\n"
      "echo:  M205 B20000.00 S0.00 T0.00 J0.02\n"
      "echo:Soft endstops: On  Min:  X0.00 Y0.00 Z0.00   Max:  X200.00 Y200.00 Z200.00\n");
  REQUIRE(limits);
  CHECK(limits->steps_per_mm == axes(80, 80, 400, 411.75));
  CHECK(limits->junction_deviation_mm == 0.02);
  CHECK(limits->jerk_mm_s == PerAxis{});
  CHECK(*limits->volume == MachineBox{{0, 1, 0}, {220, 221, 250}});
}

TEST_CASE("the settings of a Marlin 1.0, whose letters differ", "[settings]") {
  const auto limits = read(
      "echo:Steps per unit:\necho:  M92 X80.00 Y80.00 Z800.00 E92.60\n"
      "echo:Maximum Acceleration (mm/s2):\necho:  M201 X500 Y500 Z100 E1000\n"
      "echo:Acceleration: S=acceleration, T=retract acceleration\necho:  M204 S500.00 T600.00\n"
      "echo:Advanced variables: S=Min feedrate (mm/s), T=Min travel feedrate (mm/s)\n"
      "echo:  M205 S0.00 T0.00 B20000 X20.00 Z0.40 E5.00\n");
  REQUIRE(limits);
  CHECK(limits->print_acceleration_mm_s2 == 500.0);
  CHECK(limits->retract_acceleration_mm_s2 == 600.0);
  CHECK(limits->travel_acceleration_mm_s2 == 500.0);
  CHECK(limits->jerk_mm_s == axes(20, 20, 0.4, 5));
  CHECK(limits->max_feed_mm_s == PerAxis{});
  CHECK_FALSE(limits->volume);
}

TEST_CASE("of normal and silent mode the normal one counts", "[settings]") {
  const auto limits = read(
      "echo:Maximum feedrates - normal (units/s):\necho:  M203 X200.00 Y200.00 Z12.00 E120.00\n"
      "echo:Maximum feedrates - stealth (units/s):\necho:  M203 X100.00 Y100.00 Z12.00 E120.00\n");
  REQUIRE(limits);
  CHECK(limits->max_feed_mm_s == axes(200, 200, 12, 120));
}

TEST_CASE("a machine that thinks in inches is told in mm", "[settings]") {
  const auto limits = read("echo:  G20 ; (in)\necho:  M92 X2032.00 Y2032.00\necho:  M203 X10.00\n");
  REQUIRE(limits);
  CHECK(limits->steps_per_mm[0].value() == Approx(80));
  CHECK(limits->max_feed_mm_s[0].value() == Approx(254));
}

TEST_CASE("nonsense and other talk are no settings", "[settings]") {
  CHECK_FALSE(read("echo:Unknown command: \"M503\"\nT:20.00 /0.00\necho:; M92 X80\n"));
  CHECK_FALSE(read("echo:  M92 Xabc Ynan\necho:  Min: X0 Y0   Max: X1 Y1\nMax: Min:\n"));
  CHECK_FALSE(read("echo:  Min:  X9.00 Y0.00 Z0.00   Max:  X1.00 Y1.00 Z1.00\narea:{full:{min:{x:1}\n"));
}
