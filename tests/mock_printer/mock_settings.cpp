// How the firmware is set up, in its own words: M503 and M211.

#include "tests/mock_printer/mock_marlin.h"

namespace voidpath::test::mock {
namespace {

std::string axes(const char* name, const Axes& values, int decimals = 2) {
  std::string line = std::string("echo:  ") + name;
  for (std::size_t i = 0; i < kAxes; ++i)
    line += std::string(" ") + kAxisLetters[i] + fixed(values[i], decimals);
  return line;
}

std::string per_axis(const Axes& values) {
  std::string out;
  for (std::size_t i = 0; i < kAxes; ++i) out += std::string(" ") + kAxisLetters[i] + fixed(values[i], 2);
  return out;
}

std::string accelerations(const MotionSettings& s) {
  return "echo:  M204 P" + fixed(s.print_acceleration, 2) + " R" + fixed(s.retract_acceleration, 2) + " T" +
         fixed(s.travel_acceleration, 2);
}

constexpr double kMicroseconds = 1e6;

}  // namespace

void MockMarlin::report_settings() {
  if (options_.dialect.old_settings) return report_old_settings();
  const MotionSettings& s = motion_.settings();
  write_line("echo:; Linear Units:");
  write_line("echo:  G21 ; (mm)");
  write_line("echo:; Temperature Units:");
  write_line("echo:  M149 C ; Units in Celsius");
  write_line("echo:; Steps per unit:");
  write_line(axes("M92", s.steps_per_mm));
  write_line("echo:; Max feedrates (units/s):");
  write_line(axes("M203", s.max_speed));
  write_line("echo:; Max Acceleration (units/s2):");
  write_line(axes("M201", s.max_acceleration));
  write_line("echo:; Acceleration (units/s2) (P<print-accel> R<retract-accel> T<travel-accel>):");
  write_line(accelerations(s));
  write_line(std::string("echo:; Advanced (B<min_segment_time_us> S<min_feedrate> T<min_travel_feedrate> ") +
             (s.classic_jerk ? "X<max_jerk> Y<max_jerk> Z<max_jerk> E<max_jerk>):" : "J<junc_dev>):"));
  write_line("echo:  M205 B" + fixed(s.min_segment_time_s * kMicroseconds, 2) + " S" + fixed(s.min_speed, 2) +
             " T" + fixed(s.min_travel_speed, 2) +
             (s.classic_jerk ? per_axis(s.jerk) : " J" + fixed(s.junction_deviation, 2)));
  write_line("echo:; Home offset:");
  write_line("echo:  M206 X0.00 Y0.00 Z0.00");
  write_line("echo:; Material heatup parameters:");
  write_line("echo:  M145 S0 H180.00 B70.00 F0");
  write_line("echo:; Hotend PID:");
  write_line("echo:  M301 P22.20 I1.08 D114.00");
}

void MockMarlin::report_old_settings() {
  const MotionSettings& s = motion_.settings();
  write_line("echo:  G21    ; Units in mm");
  write_line("echo:  M149 C ; Units in Celsius");
  write_line("");
  write_line("echo:Filament settings: Disabled");
  write_line("echo:  M200 D1.75");
  write_line("echo:  M200 D0");
  write_line("echo:Steps per unit:");
  write_line(axes("M92", s.steps_per_mm));
  write_line("echo:Maximum feedrates (units/s):");
  write_line(axes("M203", s.max_speed));
  write_line("echo:Maximum Acceleration (units/s2):");
  write_line(axes("M201", s.max_acceleration, 0));
  write_line("echo:Acceleration (units/s2): P<print_accel> R<retract_accel> T<travel_accel>");
  write_line(accelerations(s));
  write_line(std::string("echo:Advanced: S<min_feedrate> T<min_travel_feedrate> B<min_segment_time_us> ") +
             (s.classic_jerk ? "X<max_xy_jerk> Z<max_z_jerk> E<max_e_jerk>" : "J<junc_dev>"));
  write_line("echo:  M205 S" + fixed(s.min_speed, 2) + " T" + fixed(s.min_travel_speed, 2) + " B" +
             fixed(s.min_segment_time_s * kMicroseconds, 0) +
             (s.classic_jerk ? per_axis(s.jerk) : " J" + fixed(s.junction_deviation, 2)));
  write_line("echo:Home offset:");
  write_line("echo:  M206 X0.00 Y0.00 Z0.00");
}

void MockMarlin::report_volume() {
  const std::string range = "  Min:  X0.00 Y0.00 Z0.00   Max:  X" + fixed(options_.volume_mm[0], 2) + " Y" +
                            fixed(options_.volume_mm[1], 2) + " Z" + fixed(options_.volume_mm[2], 2);
  if (options_.dialect.old_settings) return write_line("echo:Soft endstops: Off" + range);
  write_line("echo:  M211 S0 ; OFF");
  write_line("echo:" + range);
}

}  // namespace voidpath::test::mock
