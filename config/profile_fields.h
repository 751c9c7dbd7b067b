#pragma once

#include "config/config.h"
#include "config/fields.h"

/// Every key of a profile, its variable and its range, once. V is Reader or Writer.
namespace voidpath::config {

inline constexpr Range kSpeed{0.1, 2000};
inline constexpr Range kAcceleration{0, 100000};
inline constexpr Range kTemperature{0, 500};
inline constexpr Range kShare{0, 1};

template <class V>
void visit_machine(V& v, Profile& p) {
  auto& l = p.limits;
  auto& m = p.print.machine;
  v.section("machine", [&](auto& s) {
    s.text("name", m.name);
    s.choice("firmware", l.firmware, {{"marlin", motion::Firmware::marlin}, {"s3g", motion::Firmware::s3g}});
    s.choice("stepping", l.stepping,
             {{"marlin-2.0", motion::Stepping::marlin_2_0},
              {"marlin-2.1.3", motion::Stepping::marlin_2_1_3},
              {"ideal", motion::Stepping::ideal}});
    s.numbers("bed_mm", m.bed_mm, {10, 2000});
    s.number("height_mm", m.height_mm, {10, 2000});
    s.flag("origin_at_centre", m.origin_at_centre);
    s.number("nozzle_mm", m.nozzle_mm, {0.1, 2});
    s.flag("relative_e", m.relative_e);
    s.flag("arcs", m.arcs);
    s.flag("progress", m.progress);
    s.lines("thumbnails", m.thumbnails);
    s.integer("extruders", p.extruders, {1, 2});
    s.flag("heated_bed", p.heated_bed);
    s.per_axis("steps_per_mm", l.steps_per_mm, {1, 100000});
    s.per_axis("max_speed_mm_s", l.max_speed_mm_s, kSpeed);
    s.per_axis("max_acceleration_mm_s2", l.max_acceleration_mm_s2, {1, 100000});
    s.section("acceleration_mm_s2", [&](auto& a) {
      a.number("print", l.print_acceleration_mm_s2, {1, 100000});
      a.number("retract", l.retract_acceleration_mm_s2, {1, 100000});
      a.number("travel", l.travel_acceleration_mm_s2, {1, 100000});
    });
    s.number("junction_deviation_mm", l.junction_deviation_mm, {0.001, 1});
    s.per_axis("jerk_mm_s", l.jerk_mm_s, {0, 200});
    s.per_axis("homing_speed_mm_s", l.homing_speed_mm_s, kSpeed);
    s.integer("block_buffer", l.block_buffer, {4, 1024});
    s.number("min_segment_time_us", l.min_segment_time_us, {0, 1e6});
    s.section("serial", [&](auto& a) {
      a.integer("rx_bytes", l.rx_bytes, {32, 65536});
      a.integer("command_queue", l.command_queue, {1, 1024});
    });
  });
  v.section("gcode", [&](auto& s) {
    s.text("start", m.start_gcode);
    s.text("end", m.end_gcode);
    s.lines("cancel", p.cancel_gcode);
  });
}

template <class V>
void visit_filament(V& v, toolpath::PrintSettings& p) {
  v.section("filament", [&](auto& s) {
    auto& f = p.filament;
    s.text("name", f.name);
    s.number("diameter_mm", f.diameter_mm, {1, 4});
    s.number("density_g_cm3", f.density_g_cm3, {0.1, 20});
    s.number("flow", f.flow, {0.1, 3});
    s.number("first_layer_flow", f.first_layer_flow, {0.1, 3});
    s.number("nozzle_c", f.nozzle_c, kTemperature);
    s.number("nozzle_first_layer_c", f.nozzle_first_layer_c, kTemperature);
    s.number("bed_c", f.bed_c, kTemperature);
    s.number("bed_first_layer_c", f.bed_first_layer_c, kTemperature);
    s.number("max_flow_mm3_s", f.max_flow_mm3_s, {0, 1000});
    s.number("linear_advance_s", f.linear_advance_s, {0, 10});
  });
  v.section("cooling", [&](auto& s) {
    auto& c = p.cooling;
    s.flag("enabled", c.enabled);
    s.number("fan_min", c.fan_min, kShare);
    s.number("fan_max", c.fan_max, kShare);
    s.number("bridge_fan", c.bridge_fan, kShare);
    s.integer("fan_off_layers", c.fan_off_layers, {0, 1000});
    s.integer("full_fan_at_layer", c.full_fan_at_layer, {0, 1000});
    s.number("slow_below_s", c.slow_below_s, {0, 600});
    s.number("min_speed_mm_s", c.min_speed_mm_s, kSpeed);
    s.number("full_fan_below_s", c.full_fan_below_s, {0, 600});
  });
}

template <class V>
void visit_supports(V& s, toolpath::SliceSettings& x) {
  using toolpath::SupportMode;
  using toolpath::SupportStyle;
  s.choice("support", x.support,
           {{"none", SupportMode::none}, {"plate", SupportMode::plate}, {"everywhere", SupportMode::everywhere}});
  s.choice("support_style", x.support_style, {{"grid", SupportStyle::grid}, {"tree", SupportStyle::tree}});
  s.number("support_angle_deg", x.support_angle_deg, {0, 90});
  s.number("support_density", x.support_density, kShare);
  s.number("support_xy_gap_mm", x.support_xy_gap_mm, {0, 10});
  s.number("support_z_gap_mm", x.support_z_gap_mm, {0, 5});
  s.integer("support_interface_layers", x.support_interface_layers, {0, 100});
  s.number("tree_tip_diameter_mm", x.tree_tip_diameter_mm, {0.2, 5});
  s.number("tree_tip_distance_mm", x.tree_tip_distance_mm, {0.5, 50});
  s.number("tree_branch_diameter_mm", x.tree_branch_diameter_mm, {0.4, 50});
  s.number("tree_branch_angle_deg", x.tree_branch_angle_deg, {5, 75});
}

/// Between part and plate: skirt, brim, raft, the first layer's outline.
template <class V>
void visit_plate(V& s, toolpath::SliceSettings& x) {
  using toolpath::BrimType;
  s.integer("skirt_loops", x.skirt_loops, {0, 100});
  s.number("skirt_gap_mm", x.skirt_gap_mm, {0, 100});
  s.integer("skirt_layers", x.skirt_layers, {0, 10000});
  s.choice("brim_type", x.brim_type,
           {{"outer", BrimType::outer}, {"inner", BrimType::inner}, {"both", BrimType::both}, {"ears", BrimType::ears}});
  s.number("brim_width_mm", x.brim_width_mm, {0, 100});
  s.number("brim_gap_mm", x.brim_gap_mm, {0, 10});
  s.number("brim_ear_angle_deg", x.brim_ear_angle_deg, {0, 180});
  s.integer("raft_layers", x.raft_layers, {0, 100});
  s.integer("raft_interface_layers", x.raft_interface_layers, {0, 100});
  s.number("raft_margin_mm", x.raft_margin_mm, {0, 100});
  s.number("raft_gap_mm", x.raft_gap_mm, {0, 5});
  s.number("elephant_foot_mm", x.elephant_foot_mm, {0, 1});
  s.number("xy_compensation_mm", x.xy_compensation_mm, {-2, 2});
  s.number("hole_compensation_mm", x.hole_compensation_mm, {-2, 2});
}

template <class V>
void visit_slicing(V& v, toolpath::PrintSettings& p) {
  using toolpath::InfillDirection;
  using toolpath::InfillPattern;
  using toolpath::SolidPattern;
  using toolpath::SeamPosition;
  const Names<SolidPattern> solid_patterns = {{"rectilinear", SolidPattern::rectilinear},
                                              {"concentric", SolidPattern::concentric},
                                              {"fermat", SolidPattern::fermat}};
  v.section("slice", [&](auto& s) {
    auto& x = p.slice;
    s.number("layer_height_mm", x.layer_height_mm, {0.02, 2});
    s.number("first_layer_height_mm", x.first_layer_height_mm, {0.02, 2});
    s.flag("adaptive_layers", x.adaptive_layers);
    s.number("min_layer_height_mm", x.min_layer_height_mm, {0.02, 2});
    s.number("max_layer_height_mm", x.max_layer_height_mm, {0.02, 2});
    s.number("adaptive_error_mm", x.adaptive_error_mm, {0.001, 1});
    s.number("line_width_mm", x.line_width_mm, {0.05, 4});
    s.number("first_layer_line_width_mm", x.first_layer_line_width_mm, {0.05, 4});
    s.integer("perimeters", x.perimeters, {0, 100});
    s.integer("top_layers", x.top_layers, {0, 1000});
    s.integer("bottom_layers", x.bottom_layers, {0, 1000});
    s.number("top_thickness_mm", x.top_thickness_mm, {0, 1000});
    s.number("bottom_thickness_mm", x.bottom_thickness_mm, {0, 1000});
    s.number("infill_density", x.infill_density, kShare);
    s.choice("infill_pattern", x.infill_pattern,
             {{"rectilinear", InfillPattern::rectilinear},
              {"grid", InfillPattern::grid},
              {"concentric", InfillPattern::concentric},
              {"gyroid", InfillPattern::gyroid},
              {"lightning", InfillPattern::lightning}});
    s.integer("infill_every_layers", x.infill_every_layers, {1, 100});
    s.choice("infill_direction", x.infill_direction,
             {{"fixed", InfillDirection::fixed}, {"part", InfillDirection::part}, {"layer", InfillDirection::layer}});
    s.number("infill_angle_deg", x.infill_angle_deg, {-360, 360});
    s.number("infill_overlap", x.infill_overlap, kShare);
    s.choice("solid_pattern", x.solid_pattern, solid_patterns);
    s.choice("top_pattern", x.top_pattern, solid_patterns);
    s.flag("external_perimeters_first", x.external_perimeters_first);
    s.number("small_perimeter_length_mm", x.small_perimeter_length_mm, {0, 10000});
    s.number("bridge_flow", x.bridge_flow, {0.1, 3});
    s.choice("seam", x.seam,
             {{"nearest", SeamPosition::nearest},
              {"aligned", SeamPosition::aligned},
              {"rear", SeamPosition::rear}});
    visit_supports(s, x);
    visit_plate(s, x);
    s.flag("spiral_vase", x.spiral_vase);
    s.number("resolution_mm", x.resolution_mm, {0, 1});
    s.number("arc_tolerance_mm", x.arc_tolerance_mm, {0, 1});
    s.number("min_infill_area_mm2", x.min_infill_area_mm2, {0, 1000});
  });
  v.section("speed", [&](auto& s) {
    auto& x = p.speed;
    s.number("perimeter_mm_s", x.perimeter, kSpeed);
    s.number("external_perimeter_mm_s", x.external_perimeter, kSpeed);
    s.number("infill_mm_s", x.infill, kSpeed);
    s.number("solid_infill_mm_s", x.solid_infill, kSpeed);
    s.number("top_solid_infill_mm_s", x.top_solid_infill, kSpeed);
    s.number("support_mm_s", x.support, kSpeed);
    s.number("bridge_mm_s", x.bridge, kSpeed);
    s.number("internal_bridge_mm_s", x.internal_bridge, kSpeed);
    s.number("small_perimeter_mm_s", x.small_perimeter, kSpeed);
    s.number("overhang_25_mm_s", x.overhang_25, {0, kSpeed.max});
    s.number("overhang_50_mm_s", x.overhang_50, {0, kSpeed.max});
    s.number("overhang_75_mm_s", x.overhang_75, {0, kSpeed.max});
    s.number("gap_fill_mm_s", x.gap_fill, kSpeed);
    s.number("travel_mm_s", x.travel, kSpeed);
    s.number("first_layer_mm_s", x.first_layer, kSpeed);
  });
  v.section("acceleration", [&](auto& s) {
    auto& x = p.acceleration;
    s.number("print_mm_s2", x.print, kAcceleration);
    s.number("first_layer_mm_s2", x.first_layer, kAcceleration);
    s.number("travel_mm_s2", x.travel, kAcceleration);
    s.number("perimeter_mm_s2", x.perimeter, kAcceleration);
    s.number("external_perimeter_mm_s2", x.external_perimeter, kAcceleration);
    s.number("infill_mm_s2", x.infill, kAcceleration);
    s.number("solid_infill_mm_s2", x.solid_infill, kAcceleration);
    s.number("top_solid_infill_mm_s2", x.top_solid_infill, kAcceleration);
    s.number("bridge_mm_s2", x.bridge, kAcceleration);
    s.number("support_mm_s2", x.support, kAcceleration);
  });
  v.section("retract", [&](auto& s) {
    auto& x = p.retract;
    s.number("length_mm", x.length_mm, {0, 20});
    s.number("speed_mm_s", x.speed_mm_s, kSpeed);
    s.number("deretract_speed_mm_s", x.deretract_speed_mm_s, kSpeed);
    s.number("lift_mm", x.lift_mm, {0, 10});
    s.number("min_travel_mm", x.min_travel_mm, {0, 1000});
    s.flag("wipe", x.wipe);
    s.flag("avoid_crossing_perimeters", x.avoid_crossing_perimeters);
  });
}

template <class V>
void visit_profile(V& v, Profile& p) {
  visit_machine(v, p);
  visit_filament(v, p.print);
  visit_slicing(v, p.print);
}

}  // namespace voidpath::config
