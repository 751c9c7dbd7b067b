#include "daemon/jobs/printer_limits.h"

#include <catch2/catch.hpp>

using namespace voidpath;
using daemon::differences;
using daemon::with_limits;

namespace {

config::Profile a_profile() {
  config::Profile p;
  p.sha256 = std::string(64, '0');
  p.print.machine.bed_mm = {220, 220};
  p.print.machine.height_mm = 250;
  return p;
}

/// What firmware set up as the profile says prints in answer to M503.
fw::FirmwareLimits alike(const config::Profile& p) {
  fw::FirmwareLimits f;
  for (std::size_t a = 0; a < 4; ++a) {
    f.steps_per_mm[a] = p.limits.steps_per_mm[a];
    f.max_feed_mm_s[a] = p.limits.max_speed_mm_s[a];
    f.max_acceleration_mm_s2[a] = p.limits.max_acceleration_mm_s2[a];
  }
  f.print_acceleration_mm_s2 = p.limits.print_acceleration_mm_s2;
  f.retract_acceleration_mm_s2 = p.limits.retract_acceleration_mm_s2;
  f.travel_acceleration_mm_s2 = p.limits.travel_acceleration_mm_s2;
  f.junction_deviation_mm = 0.01;  // of 0.013, two decimals
  f.min_segment_time_s = 0.02;
  f.volume = fw::MachineBox{{0, 0, 0}, {220, 220, 250}};
  return f;
}

}  // namespace

TEST_CASE("a printer set up as its profile says is left as it is, roundings of M503 included") {
  const auto p = a_profile();
  CHECK(differences(p, alike(p)).empty());
  const auto laid = with_limits(p, alike(p));
  CHECK(laid.limits.junction_deviation_mm == 0.013);
  CHECK(laid.sha256 == p.sha256);
  auto short_lines = alike(p);
  short_lines.line_form = fw::LineForm::dense;
  CHECK(with_limits(p, short_lines).limits.line_format == motion::LineFormat::dense);
  CHECK(differences(p, {}).empty());
}

TEST_CASE("what the printer says counts, and the difference is told in plain words") {
  const auto p = a_profile();
  auto f = alike(p);
  f.print_acceleration_mm_s2 = 800;
  f.max_feed_mm_s[2] = 5;
  const auto told = differences(p, f);
  REQUIRE(told.size() == 2);
  CHECK(told[0] == "greatest speed of Z: the printer says 5 mm/s, its profile 10");
  CHECK(told[1] == "print acceleration: the printer says 800 mm/s², its profile 1000");
  const auto laid = with_limits(p, f);
  CHECK(laid.limits.print_acceleration_mm_s2 == 800);
  CHECK(laid.limits.max_speed_mm_s[2] == 5);
  CHECK(laid.limits.travel_acceleration_mm_s2 == p.limits.travel_acceleration_mm_s2);
  CHECK(laid.sha256 != p.sha256);
  CHECK(with_limits(p, f).sha256 == laid.sha256);
  CHECK(daemon::limits_text(laid).find("print 800,") != std::string::npos);
}

TEST_CASE("a printer with classic jerk is not planned by junction deviation, nor the other way round") {
  auto p = a_profile();
  fw::FirmwareLimits f;
  f.jerk_mm_s = {8, 8, 0.4, 5};
  CHECK(differences(p, f).size() == 1);
  const auto jerky = with_limits(p, f);
  REQUIRE(jerky.limits.jerk_mm_s);
  CHECK((*jerky.limits.jerk_mm_s)[3] == 5);
  p.limits.jerk_mm_s = motion::PerAxis{10, 10, 0.4, 5};
  f = {};
  f.junction_deviation_mm = 0.02;
  const auto deviating = with_limits(p, f);
  CHECK_FALSE(deviating.limits.jerk_mm_s);
  CHECK(deviating.limits.junction_deviation_mm == 0.02);
}

TEST_CASE("room is taken away by software endstops, never given") {
  auto p = a_profile();
  fw::FirmwareLimits f;
  f.volume = fw::MachineBox{{-5, 0, 0}, {200, 260, 180}};
  const auto told = differences(p, f);
  REQUIRE(told.size() == 2);
  CHECK(told[0] == "room along X: the printer reaches 200 mm, its profile has 220");
  const auto laid = with_limits(p, f);
  CHECK(laid.print.machine.bed_mm[0] == 200);
  CHECK(laid.print.machine.bed_mm[1] == 220);
  CHECK(laid.print.machine.height_mm == 180);
  p.print.machine.origin_at_centre = true;
  f.volume = fw::MachineBox{{-90, -110, 0}, {110, 110, 250}};
  CHECK(with_limits(p, f).print.machine.bed_mm[0] == 180);
}
