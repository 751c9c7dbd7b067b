#include "tests/bench/slicer/rival.h"

#include "engine/toolpath/bead.h"
#include "engine/toolpath/emit/placeholders.h"
#include "engine/toolpath/support/supports.h"

#include <array>
#include <charconv>
#include <cmath>

namespace voidpath::bench {

namespace {

class Ini {
 public:
  void put(const std::string& key, const std::string& value) { text_ += key + " = " + value + "\n"; }
  void put(const std::string& key, const char* value) { put(key, std::string(value)); }
  void put(const std::string& key, bool value) { put(key, value ? "1" : "0"); }
  void put(const std::string& key, int value) { put(key, std::to_string(value)); }
  void put(const std::string& key, double value) { put(key, number(value)); }

  static std::string number(double value) {
    std::array<char, 32> digits{};
    const auto end =
        std::to_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::fixed, 4);
    return {digits.data(), end.ptr};
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// Several lines are one value, with "\n" between.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\n')
      out += "\\n";
    else
      out += c;
  }
  return out;
}

void put_machine(Ini& ini, const toolpath::PrintSettings& s) {
  const auto& m = s.machine;
  const double x0 = m.origin_at_centre ? -m.bed_mm[0] / 2 : 0;
  const double y0 = m.origin_at_centre ? -m.bed_mm[1] / 2 : 0;
  const std::string left = Ini::number(x0), right = Ini::number(x0 + m.bed_mm[0]);
  const std::string front = Ini::number(y0), back = Ini::number(y0 + m.bed_mm[1]);
  ini.put("bed_shape", left + "x" + front + "," + right + "x" + front + "," + right + "x" + back + "," +
                           left + "x" + back);
  ini.put("max_print_height", m.height_mm);
  ini.put("gcode_flavor", "marlin2");
  ini.put("machine_limits_usage", "ignore");
  ini.put("use_relative_e_distances", m.relative_e);
  if (m.relative_e) ini.put("layer_gcode", "G92 E0");
  ini.put("nozzle_diameter", m.nozzle_mm);
  const toolpath::Placeholders values = toolpath::placeholders(toolpath::Plan{}, s);
  ini.put("start_gcode", escaped(toolpath::expand(m.start_gcode, values, "start G-code")));
  ini.put("end_gcode", escaped(toolpath::expand(m.end_gcode, values, "end G-code")));
  ini.put("thumbnails", "");
  ini.put("retract_length", s.retract.length_mm);
  ini.put("retract_speed", s.retract.speed_mm_s);
  ini.put("deretract_speed", s.retract.deretract_speed_mm_s);
  ini.put("retract_lift", s.retract.lift_mm);
  ini.put("retract_before_travel", s.retract.min_travel_mm);
  ini.put("retract_layer_change", false);
  ini.put("wipe", false);
}

void put_filament(Ini& ini, const toolpath::PrintSettings& s) {
  const auto& f = s.filament;
  ini.put("filament_diameter", f.diameter_mm);
  ini.put("filament_density", f.density_g_cm3);
  ini.put("extrusion_multiplier", f.flow);
  ini.put("temperature", static_cast<int>(f.nozzle_c));
  ini.put("first_layer_temperature", static_cast<int>(f.nozzle_first_layer_c));
  ini.put("bed_temperature", static_cast<int>(f.bed_c));
  ini.put("first_layer_bed_temperature", static_cast<int>(f.bed_first_layer_c));
  ini.put("filament_max_volumetric_speed", f.max_flow_mm3_s);
  const auto& c = s.cooling;
  ini.put("cooling", c.enabled);
  ini.put("fan_always_on", c.enabled && c.fan_min > 0);
  ini.put("min_fan_speed", static_cast<int>(std::lround(100 * c.fan_min)));
  ini.put("max_fan_speed", static_cast<int>(std::lround(100 * c.fan_max)));
  ini.put("bridge_fan_speed", static_cast<int>(std::lround(100 * c.bridge_fan)));
  ini.put("disable_fan_first_layers", c.fan_off_layers);
  ini.put("slowdown_below_layer_time", static_cast<int>(std::lround(c.slow_below_s)));
  ini.put("fan_below_layer_time", static_cast<int>(std::lround(c.full_fan_below_s)));
  ini.put("min_print_speed", c.min_speed_mm_s);
}

const char* pattern_name(toolpath::InfillPattern pattern) {
  switch (pattern) {
    case toolpath::InfillPattern::grid:
      return "grid";
    case toolpath::InfillPattern::concentric:
      return "concentric";
    case toolpath::InfillPattern::gyroid:
      return "gyroid";
    case toolpath::InfillPattern::lightning:
      return "lightning";
    case toolpath::InfillPattern::rectilinear:
      break;
  }
  return "rectilinear";
}

void put_shells(Ini& ini, const toolpath::SliceSettings& s) {
  ini.put("layer_height", s.layer_height_mm);
  ini.put("first_layer_height", s.first_layer_height_mm);
  for (const char* key :
       {"extrusion_width", "external_perimeter_extrusion_width", "perimeter_extrusion_width",
        "infill_extrusion_width", "solid_infill_extrusion_width", "top_infill_extrusion_width",
        "support_material_extrusion_width"})
    ini.put(key, s.line_width_mm);
  ini.put("first_layer_extrusion_width", s.first_layer_line_width_mm);
  ini.put("perimeters", s.perimeters);
  ini.put("perimeter_generator", "classic");
  ini.put("external_perimeters_first", s.external_perimeters_first);
  ini.put("extra_perimeters", false);
  ini.put("thin_walls", true);  // ours fills what is too thin for two walls
  ini.put("gap_fill_enabled", true);
  ini.put("overhangs", true);
  ini.put("top_solid_layers", s.top_layers);
  ini.put("bottom_solid_layers", s.bottom_layers);
  ini.put("top_solid_min_thickness", s.top_thickness_mm);
  ini.put("bottom_solid_min_thickness", s.bottom_thickness_mm);
  ini.put("bridge_flow_ratio", s.bridge_flow);
  ini.put("infill_every_layers", s.infill_every_layers);
  ini.put("fill_density", Ini::number(100 * s.infill_density) + "%");
  ini.put("fill_pattern", pattern_name(s.infill_pattern));
  const auto solid = [](toolpath::SolidPattern pattern) {
    return pattern == toolpath::SolidPattern::rectilinear ? "rectilinear" : "concentric";
  };
  ini.put("top_fill_pattern", solid(s.top_pattern));
  ini.put("bottom_fill_pattern", solid(s.solid_pattern));
  ini.put("fill_angle", s.infill_angle_deg);
  ini.put("infill_overlap", Ini::number(100 * s.infill_overlap) + "%");
  ini.put("solid_infill_below_area", s.min_infill_area_mm2);
  ini.put("elefant_foot_compensation", s.elephant_foot_mm);
  ini.put("gcode_resolution", s.resolution_mm);
  ini.put("seam_position", s.seam == toolpath::SeamPosition::aligned ? "aligned"
                           : s.seam == toolpath::SeamPosition::rear  ? "rear"
                                                                     : "nearest");
}

void put_support(Ini& ini, const toolpath::SliceSettings& s) {
  ini.put("support_material", s.support != toolpath::SupportMode::none);
  ini.put("support_material_auto", true);
  ini.put("support_material_buildplate_only", s.support == toolpath::SupportMode::plate);
  // PrusaSlicer counts its threshold from the horizontal.
  ini.put("support_material_threshold", static_cast<int>(std::lround(90 - s.support_angle_deg)));
  ini.put("support_material_style", "grid");
  ini.put("support_material_pattern", "rectilinear");
  ini.put("support_material_with_sheath", false);
  const double line = toolpath::bead_spacing_mm(s.line_width_mm, s.layer_height_mm);
  ini.put("support_material_spacing", line / s.support_density - line);
  ini.put("support_material_interface_layers", s.support_interface_layers);
  ini.put("support_material_bottom_interface_layers", 0);
  ini.put("support_material_interface_spacing", line / toolpath::kInterfaceDensity - line);
  ini.put("support_material_xy_spacing", s.support_xy_gap_mm);
  ini.put("support_material_contact_distance", s.support_z_gap_mm);
  ini.put("dont_support_bridges", true);
  ini.put("skirts", s.skirt_loops);
  ini.put("skirt_distance", s.skirt_gap_mm);
  ini.put("skirt_height", s.skirt_layers);
  ini.put("min_skirt_length", 0);
  ini.put("brim_type", s.brim_width_mm > 0 ? "outer_only" : "no_brim");
  ini.put("brim_width", s.brim_width_mm);
}

void put_speeds(Ini& ini, const toolpath::PrintSettings& s) {
  const auto& v = s.speed;
  ini.put("perimeter_speed", v.perimeter);
  ini.put("external_perimeter_speed", v.external_perimeter);
  ini.put("small_perimeter_speed", v.small_perimeter);
  ini.put("infill_speed", v.infill);
  ini.put("solid_infill_speed", v.solid_infill);
  ini.put("top_solid_infill_speed", v.top_solid_infill);
  ini.put("support_material_speed", v.support);
  ini.put("support_material_interface_speed", "100%");
  ini.put("bridge_speed", v.bridge);
  ini.put("gap_fill_speed", v.gap_fill);
  ini.put("travel_speed", v.travel);
  ini.put("first_layer_speed", v.first_layer);
  ini.put("default_acceleration", s.acceleration.print);
  ini.put("first_layer_acceleration", s.acceleration.first_layer);
}

}  // namespace

std::string prusa_config(const toolpath::PrintSettings& settings) {
  Ini ini;
  put_machine(ini, settings);
  put_filament(ini, settings);
  put_shells(ini, settings.slice);
  put_support(ini, settings.slice);
  put_speeds(ini, settings);
  return ini.text();
}

}  // namespace voidpath::bench
