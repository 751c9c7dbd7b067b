#include "engine/toolpath/emit/emit.h"

#include "engine/gcode/estimate.h"
#include "engine/toolpath/emit/gcode_text.h"
#include "engine/toolpath/emit/pace.h"
#include "engine/toolpath/emit/placeholders.h"
#include "engine/toolpath/travel/travel.h"
#include "tests/engine/toolpath/shapes.h"

#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <string>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using toolpath::Role;

namespace {

/// What the text says, read by the plain rules of G-code.
struct Reading {
  double e_total = 0;  ///< filament that went in on moves in the plane
  double e_sum = 0;    ///< all E, retractions included
  double travel = 0;
  std::size_t retractions = 0;
  std::size_t layers = 0;
  std::vector<double> layer_seconds;
  std::vector<double> first_layer_speeds;
  std::map<std::string, int> types;
  std::vector<std::string> lines;
  bool z_monotonic = true;
};

Reading read(const std::string& text, bool relative) {
  Reading r;
  double x = 0, y = 0, z = 0, e = 0, f = 0, top = 0;
  bool placed = false;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    r.lines.push_back(line);
    if (line == ";LAYER_CHANGE") {
      ++r.layers;
      r.layer_seconds.push_back(0);
    }
    if (line.rfind(";TYPE:", 0) == 0) ++r.types[line.substr(6)];
    if (line == "G92 E0") e = 0;
    if (line.rfind("G1", 0) != 0) continue;
    double nx = x, ny = y, nz = z, ne = relative ? 0 : e;
    bool plane = false;
    for (std::size_t i = 2; i < line.size(); ++i) {
      if (line[i] == ' ') continue;
      double v = 0;
      const auto end = std::from_chars(line.data() + i + 1, line.data() + line.size(), v).ptr;
      if (line[i] == 'X') nx = v, plane = true;
      if (line[i] == 'Y') ny = v, plane = true;
      if (line[i] == 'Z') nz = v;
      if (line[i] == 'E') ne = v;
      if (line[i] == 'F') f = v / 60;
      i = static_cast<std::size_t>(end - line.data()) - 1;
    }
    const double de = relative ? ne : ne - e;
    const double d = std::hypot(nx - x, ny - y);
    r.e_sum += de;
    if (de < 0) ++r.retractions;
    if (plane && de > 0) {
      r.e_total += de;
      if (r.layers == 1) r.first_layer_speeds.push_back(f);
      if (nz < top) r.z_monotonic = false;
      top = std::max(top, nz);
    }
    if (plane && de == 0 && placed) r.travel += d;
    if (plane) placed = true;
    if (!r.layer_seconds.empty() && f > 0 && plane && placed) r.layer_seconds.back() += d / f;
    x = nx, y = ny, z = nz;
    if (!relative) e = ne;
  }
  return r;
}

std::string text_of(const toolpath::Plan& plan, const toolpath::PrintSettings& s,
                    toolpath::EmitStats* stats = nullptr) {
  std::ostringstream out;
  const auto got = toolpath::emit(plan, s, "made by a test", out, {});
  if (stats != nullptr) *stats = got;
  return out.str();
}

}  // namespace

TEST_CASE("statistics are what the text says, with relative and absolute E alike") {
  toolpath::PrintSettings s;
  s.filament.flow = 0.97;
  s.retract.lift_mm = 0.2;
  const auto plan = toolpath::build(arch_stack(40, 15, 6, 2, 6), s);
  toolpath::EmitStats stats;
  const Reading relative = read(text_of(plan, s, &stats), true);
  CHECK(relative.layers == stats.layers);
  CHECK(relative.retractions == stats.retractions);
  CHECK(stats.retractions > 10);
  CHECK(relative.e_total == Approx(stats.filament_mm).margin(2e-5));
  CHECK(relative.travel == Approx(stats.travel_mm).epsilon(1e-3));
  CHECK(relative.z_monotonic);
  double volume = volume_mm3(plan) * s.filament.flow;
  CHECK(stats.extruded_mm3 == Approx(volume).epsilon(1e-9));
  CHECK(stats.filament_mm == Approx(volume / (3.14159265358979 / 4 * 1.75 * 1.75)).epsilon(1e-9));

  s.machine.relative_e = false;
  toolpath::EmitStats stats_absolute;
  const Reading absolute = read(text_of(plan, s, &stats_absolute), false);
  CHECK(absolute.e_total == Approx(relative.e_total).margin(1e-4));
  CHECK(absolute.e_sum == Approx(relative.e_sum).margin(1e-4));
  CHECK(stats_absolute.filament_mm == stats.filament_mm);
}

TEST_CASE("the same bytes on one thread and many") {
  toolpath::PrintSettings s;
  s.slice.infill_pattern = toolpath::InfillPattern::gyroid;
  for (const auto& stack : {arch_stack(40, 15, 6, 2, 6), cone_stack(3, 6, 14), cup_stack(30, 6, 0.7, 1)}) {
    std::string first;
    for (const unsigned threads : {1u, 2u, 7u}) {
      run::Context ctx;
      ctx.threads = threads;
      const std::string text = text_of(toolpath::build(stack, s, ctx), s);
      if (first.empty()) first = text;
      CHECK(text == first);
    }
  }
}

TEST_CASE("numbers are short and exact") {
  std::string out;
  toolpath::put_scaled(out, 1500, 3);
  CHECK(out == "1.5");
  CHECK(toolpath::decimal(0, 3) == "0");
  CHECK(toolpath::decimal(-0.005, 3) == "-0.005");
  CHECK(toolpath::decimal(12.34567, 5) == "12.34567");
  CHECK(toolpath::decimal(120, 3) == "120");
  CHECK(toolpath::decimal(0.2, 3) == "0.2");
}

TEST_CASE("steps of a few thousandths are no moves, and their material is not lost") {
  auto s = bare_settings();
  toolpath::Plan plan = toolpath::build(box_stack(10, 10, 1), s);
  const double before = read(text_of(plan, s), s.machine.relative_e).e_total;
  const std::size_t lines = read(text_of(plan, s), s.machine.relative_e).lines.size();
  for (auto& layer : plan.layers)
    for (auto& path : layer.paths) {
      const geom::Point& p = path.points[1];
      path.points.insert(path.points.begin() + 1, {{p.x - 2500, p.y}, {p.x - 1200, p.y + 1500}});
    }
  const Reading after = read(text_of(plan, s), s.machine.relative_e);
  CHECK(after.lines.size() == lines);
  CHECK(after.e_total == Approx(before).epsilon(1e-3));
}

TEST_CASE("placeholders are replaced, unknown ones named") {
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  s.machine.start_gcode =
      "M104 S{nozzle_first_layer_c}\nM140 S{bed_first_layer_c} ; {filament}\nG1 X{first_layer_min_x} "
      "Y{first_layer_max_y}\n; {layer_count} {max_z} {{x}} { y }";
  s.machine.end_gcode = "M104 S0";
  s.filament.nozzle_first_layer_c = 215;
  s.filament.nozzle_c = 205;
  const auto plan = toolpath::build(box_stack(20, 10, 2), s);
  const std::string text = text_of(plan, s);
  CHECK(text.find("M104 S215\nM140 S60 ; PLA\n") != std::string::npos);
  CHECK(text.find("G1 X50 Y60\n") != std::string::npos);
  CHECK(text.find("; 10 2 {x} { y }\n") != std::string::npos);
  // After the first layer, once.
  const auto change = text.find("M104 S205\n");
  CHECK(change > text.find(";Z:0.4"));
  CHECK(change < text.find(";Z:0.6"));
  CHECK(text.find("M140 S60\n") == std::string::npos);
  s.machine.end_gcode = "M104 S{nozle_c}";
  CHECK_THROWS_WITH(text_of(plan, s), Catch::Contains("{nozle_c}") && Catch::Contains("end G-code"));
  s.machine.start_gcode.clear();
  s.machine.end_gcode.clear();
  CHECK(text_of(plan, s).find("M104") == std::string::npos);
}

TEST_CASE("the first layer is printed at its own speed and layers are announced") {
  toolpath::PrintSettings s;
  const auto plan = toolpath::build(box_stack(30, 30, 3), s);
  const std::string text = text_of(plan, s);
  const Reading r = read(text, true);
  REQUIRE(!r.first_layer_speeds.empty());
  for (const double v : r.first_layer_speeds) CHECK(v == Approx(s.speed.first_layer).margin(0.01));
  CHECK(r.layers == 15);
  for (std::size_t i = 0; i + 1 < r.lines.size(); ++i)
    if (r.lines[i] == ";LAYER_CHANGE") CHECK(r.lines[i + 1].rfind(";Z:", 0) == 0);
  for (const char* type : {"Skirt/Brim", "External perimeter", "Perimeter", "Solid infill", "Internal infill",
                           "Top solid infill"})
    CHECK(r.types.count(type) == 1);
}

TEST_CASE("small layers take their time, and no more, or go as slowly as allowed") {
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  motion::MachineLimits limits;
  limits.baud = 0;
  std::size_t slowed = 0;
  for (const double size : {2.0, 6.0, 12.0, 25.0, 40.0}) {
    const auto plan = toolpath::build(box_stack(size, size, 3), s);
    std::istringstream text(text_of(plan, s));
    const auto timed = gcode::estimate(text, limits);
    REQUIRE(timed.layers.size() == plan.layers.size());
    std::optional<geom::Point> at;
    for (std::size_t i = 0; i < plan.layers.size(); ++i) {
      const auto travels = toolpath::plan_travels(plan.layers[i], at, s);
      at = toolpath::end_of_layer(plan.layers[i]);
      const auto pace = toolpath::pace_of_layer(plan.layers[i], i, s, limits, travels);
      bool at_floor = true;
      for (const auto& p : plan.layers[i].paths)
        if (!toolpath::keeps_speed(p.role))
          at_floor = at_floor && pace.apply(toolpath::path_speed_mm_s(p, i, s), p.role) <=
                                     s.cooling.min_speed_mm_s * 1.001;
      CHECK((pace.seconds >= s.cooling.slow_below_s - 0.03 || at_floor));
      if (pace.factor < 1) ++slowed;
      if (pace.factor < 1 && !at_floor) CHECK(pace.seconds <= s.cooling.slow_below_s + 0.1);
      // The text takes as long by the same planner, but for the way to the layer: up to a second for its
      // height and a retraction.
      if (pace.seconds < s.cooling.full_fan_below_s) {
        CHECK(timed.layers[i].seconds >= pace.seconds * 0.98 - 0.1);
        CHECK(timed.layers[i].seconds <= pace.seconds * 1.02 + 1.0);
      }
      CHECK(pace.fan >= (i == 0 ? 0.0 : s.cooling.fan_min));
    }
  }
  CHECK(slowed > 10);
}

TEST_CASE("speeds keep to the filament's flow limit") {
  toolpath::PrintSettings s;
  s.filament.max_flow_mm3_s = 2;
  const auto plan = toolpath::build(box_stack(30, 30, 3), s);
  for (std::size_t i = 0; i < plan.layers.size(); ++i)
    for (const auto& p : plan.layers[i].paths)
      CHECK(toolpath::path_speed_mm_s(p, i, s) * p.area_mm2 * s.filament.flow <= 2.0 * 1.0001);
}

TEST_CASE("travel inside the outline is not retracted, travel across air is") {
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  toolpath::LayerPlan layer;
  layer.span = {0, 0.2};
  layer.outline = {rectangle(0, 0, 20, 20), rectangle(40, 0, 60, 20)};
  auto line = [&](double x0, double x1) {
    toolpath::Path p;
    p.points = {{geom::from_mm(x0), geom::from_mm(5)}, {geom::from_mm(x1), geom::from_mm(5)}};
    p.area_mm2 = 0.08;
    return p;
  };
  layer.paths = {line(1, 3), line(15, 18)};
  toolpath::EmitStats stats;
  text_of({{layer}}, s, &stats);
  CHECK(stats.retractions == 1);  // the one at the end
  layer.paths.push_back(line(45, 50));
  text_of({{layer}}, s, &stats);
  CHECK(stats.retractions == 2);
  s.retract.length_mm = 0;
  text_of({{layer}}, s, &stats);
  CHECK(stats.retractions == 0);
}

TEST_CASE("accelerations are written only when asked for") {
  toolpath::PrintSettings s;
  const auto plan = toolpath::build(box_stack(20, 20, 1), s);
  CHECK(text_of(plan, s).find("M204") == std::string::npos);
  s.acceleration = {1000, 500, 1500};
  const std::string text = text_of(plan, s);
  for (const char* line : {"M204 S1000\n", "M204 S500\n", "M204 S1500\n"})
    CHECK(text.find(line) != std::string::npos);
}

TEST_CASE("each feature has its acceleration, and none where the printer's own is to hold") {
  toolpath::PrintSettings s;
  s.acceleration.print = 1000;
  s.acceleration.external_perimeter = 400;
  toolpath::Path path;
  for (const auto& [role, wanted] : {std::pair{Role::external_perimeter, 400.0}, {Role::infill, 1000.0}}) {
    path.role = role;
    CHECK(toolpath::path_acceleration_mm_s2(path, 3, s) == wanted);
  }
  s.acceleration.first_layer = 300;
  CHECK(toolpath::path_acceleration_mm_s2(path, 0, s) == 300);
  s.acceleration.print = 0;
  CHECK(toolpath::path_acceleration_mm_s2(path, 3, s) == 0);
  CHECK(toolpath::path_acceleration_mm_s2(path, 0, s) == 0);
}

TEST_CASE("the fan gains speed evenly up to its layer") {
  toolpath::PrintSettings s;
  s.cooling.fan_off_layers = 2;
  s.cooling.full_fan_at_layer = 6;
  const auto plan = toolpath::build(box_stack(10, 10, 2), s);
  const double share[] = {0, 0, 0.25, 0.5, 0.75, 1, 1, 1, 1, 1};
  for (std::size_t i = 0; i < plan.layers.size(); ++i) {
    const auto pace = toolpath::pace_of_layer(plan.layers[i], i, s);
    CHECK(pace.fan == Approx(share[i] * s.cooling.fan_max));
    CHECK(pace.bridge_fan == Approx(share[i] * s.cooling.bridge_fan));
  }
}

TEST_CASE("linear advance is passed on where the filament has it") {
  toolpath::PrintSettings s;
  const auto plan = toolpath::build(box_stack(10, 10, 1), s);
  CHECK(text_of(plan, s).find("M900") == std::string::npos);
  s.filament.linear_advance_s = 0.045;
  CHECK(text_of(plan, s).find("\nM900 K0.045\n") != std::string::npos);
}
