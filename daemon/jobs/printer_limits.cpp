#include "daemon/jobs/printer_limits.h"

#include "config/digest.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>

namespace voidpath::daemon {
namespace {

/// Firmware prints two decimals: 0.01 for a junction deviation of 0.013.
constexpr double kPrinted = 0.005;
/// And a little for binary fractions.
constexpr double kRounding = 1e-6;
/// Software endstops are set by whole or half millimetres; less is rounding. mm
constexpr double kSameReach_mm = 0.1;
constexpr const char* kAxes[] = {"X", "Y", "Z", "E"};

std::string number(double value) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, 6).ptr;
  return {buffer, end};
}

bool same(double a, double b) { return std::abs(a - b) <= kPrinted + kRounding * std::abs(b); }

/// Walks over every value that both sides know: name, unit, the profile's (to be written to), the firmware's.
using Visit =
    std::function<void(const std::string& name, const std::string& unit, double& ours, double theirs)>;

void each_value(motion::MachineLimits& ours, const fw::FirmwareLimits& theirs, const Visit& visit) {
  const auto axes = [&](const char* name, const char* unit, motion::PerAxis& mine, const fw::PerAxis& other) {
    for (std::size_t a = 0; a < 4; ++a)
      if (other[a]) visit(std::string(name) + " of " + kAxes[a], unit, mine[a], *other[a]);
  };
  axes("steps", "/mm", ours.steps_per_mm, theirs.steps_per_mm);
  axes("greatest speed", " mm/s", ours.max_speed_mm_s, theirs.max_feed_mm_s);
  axes("greatest acceleration", " mm/s²", ours.max_acceleration_mm_s2, theirs.max_acceleration_mm_s2);
  const auto one = [&](const char* name, const char* unit, double& mine, const std::optional<double>& other) {
    if (other) visit(name, unit, mine, *other);
  };
  one("print acceleration", " mm/s²", ours.print_acceleration_mm_s2, theirs.print_acceleration_mm_s2);
  one("retract acceleration", " mm/s²", ours.retract_acceleration_mm_s2, theirs.retract_acceleration_mm_s2);
  one("travel acceleration", " mm/s²", ours.travel_acceleration_mm_s2, theirs.travel_acceleration_mm_s2);
  one("least speed", " mm/s", ours.min_speed_mm_s, theirs.min_feed_mm_s);
  one("least travel speed", " mm/s", ours.min_travel_speed_mm_s, theirs.min_travel_feed_mm_s);
  if (theirs.min_segment_time_s)
    visit("least segment time", " µs", ours.min_segment_time_us, *theirs.min_segment_time_s * 1e6);
  if (theirs.junction_deviation_mm) {
    if (!ours.jerk_mm_s)
      visit("junction deviation", " mm", ours.junction_deviation_mm, *theirs.junction_deviation_mm);
  } else if (ours.jerk_mm_s) {
    axes("jerk", " mm/s", *ours.jerk_mm_s, theirs.jerk_mm_s);
  }
}

/// Corners are judged by junction deviation or by jerk; the firmware knows which.
std::string other_corners(const motion::MachineLimits& ours, const fw::FirmwareLimits& theirs) {
  if (theirs.junction_deviation_mm && ours.jerk_mm_s)
    return "corners: the printer goes by a junction deviation of " + number(*theirs.junction_deviation_mm) +
           " mm, its profile by jerk";
  if (!theirs.junction_deviation_mm && theirs.jerk_mm_s[0] && !ours.jerk_mm_s)
    return "corners: the printer goes by jerk (X " + number(*theirs.jerk_mm_s[0]) +
           " mm/s), its profile by junction deviation";
  return {};
}

void take_corners(motion::MachineLimits& ours, const fw::FirmwareLimits& theirs) {
  if (theirs.junction_deviation_mm && ours.jerk_mm_s) {
    ours.jerk_mm_s.reset();
    ours.junction_deviation_mm = *theirs.junction_deviation_mm;
  } else if (!theirs.junction_deviation_mm && theirs.jerk_mm_s[0] && !ours.jerk_mm_s) {
    const double x = *theirs.jerk_mm_s[0];
    // Firmware that does not tell an axis has Marlin's own default there.
    ours.jerk_mm_s = motion::PerAxis{x, theirs.jerk_mm_s[1].value_or(x), theirs.jerk_mm_s[2].value_or(0.4),
                                     theirs.jerk_mm_s[3].value_or(5)};
  }
}

motion::LineFormat format_of(fw::LineForm form) {
  switch (form) {
    case fw::LineForm::plain:
      return motion::LineFormat::plain;
    case fw::LineForm::dense:
      return motion::LineFormat::dense;
    case fw::LineForm::packed:
      return motion::LineFormat::packed;
  }
  return motion::LineFormat::plain;
}

/// How much of the bed the axes reach, and how high.
std::array<double, 3> reach(const toolpath::MachineShape& machine, const fw::MachineBox& box) {
  std::array<double, 3> out{box.max_mm[0], box.max_mm[1], box.max_mm[2]};
  if (machine.origin_at_centre)
    for (std::size_t a = 0; a < 2; ++a) out[a] = 2 * std::min(box.max_mm[a], -box.min_mm[a]);
  return out;
}

void each_side(toolpath::MachineShape& machine, const fw::FirmwareLimits& theirs,
               const std::function<void(const std::string& name, double& ours, double reach)>& visit) {
  if (!theirs.volume) return;
  const auto far = reach(machine, *theirs.volume);
  double* ours[] = {&machine.bed_mm[0], &machine.bed_mm[1], &machine.height_mm};
  for (std::size_t a = 0; a < 3; ++a)
    if (far[a] > 0 && far[a] < *ours[a] - kSameReach_mm) visit(kAxes[a], *ours[a], far[a]);
}

}  // namespace

std::vector<std::string> differences(const config::Profile& profile, const fw::FirmwareLimits& firmware) {
  std::vector<std::string> out;
  motion::MachineLimits limits = profile.limits;
  each_value(limits, firmware,
             [&](const std::string& name, const std::string& unit, double& ours, double theirs) {
               if (!same(ours, theirs))
                 out.push_back(name + ": the printer says " + number(theirs) + unit + ", its profile " +
                               number(ours));
             });
  if (const auto corners = other_corners(profile.limits, firmware); !corners.empty()) out.push_back(corners);
  toolpath::MachineShape machine = profile.print.machine;
  each_side(machine, firmware, [&](const std::string& axis, double& ours, double far) {
    out.push_back("room along " + axis + ": the printer reaches " + number(far) + " mm, its profile has " +
                  number(ours));
  });
  return out;
}

config::Profile with_limits(config::Profile profile, const fw::FirmwareLimits& firmware) {
  profile.limits.line_format = format_of(firmware.line_form);
  const auto told = differences(profile, firmware);
  if (told.empty()) return profile;
  each_value(profile.limits, firmware,
             [](const std::string&, const std::string&, double& ours, double theirs) {
               if (!same(ours, theirs)) ours = theirs;
             });
  take_corners(profile.limits, firmware);
  each_side(profile.print.machine, firmware,
            [](const std::string&, double& ours, double far) { ours = far; });
  std::string all = profile.sha256;
  for (const auto& one : told) all += "\n" + one;
  profile.sha256 = config::sha256_of(all);
  return profile;
}

std::string limits_text(const config::Profile& profile) {
  const auto& l = profile.limits;
  const auto axes = [](const motion::PerAxis& v) {
    return number(v[0]) + "/" + number(v[1]) + "/" + number(v[2]) + "/" + number(v[3]);
  };
  const auto& m = profile.print.machine;
  return axes(l.steps_per_mm) + " steps/mm; at most " + axes(l.max_speed_mm_s) + " mm/s and " +
         axes(l.max_acceleration_mm_s2) + " mm/s²; accelerations print " +
         number(l.print_acceleration_mm_s2) + ", retract " + number(l.retract_acceleration_mm_s2) +
         ", travel " + number(l.travel_acceleration_mm_s2) + " mm/s²; " +
         (l.jerk_mm_s ? "jerk " + axes(*l.jerk_mm_s) + " mm/s"
                      : "junction deviation " + number(l.junction_deviation_mm) + " mm") +
         "; room " + number(m.bed_mm[0]) + " x " + number(m.bed_mm[1]) + " x " + number(m.height_mm) + " mm";
}

}  // namespace voidpath::daemon
