#include "daemon/slicer/cura_settings.h"

#include "config/config.h"
#include "config/fields.h"
#include "engine/toolpath/bead.h"
#include "engine/toolpath/emit/placeholders.h"
#include "engine/toolpath/support/supports.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <initializer_list>

namespace voidpath::daemon {

namespace {

/// CuraEngine's word for each of ours, by groups that take the same value.
class Putter {
 public:
  using Keys = std::initializer_list<const char*>;
  explicit Putter(CuraSettings& out) : out_(out) {}
  void operator()(Keys keys, const std::string& value) {
    for (const char* key : keys) out_[key] = value;
  }
  void operator()(Keys keys, const char* value) { (*this)(keys, std::string(value)); }
  void operator()(Keys keys, double value) { (*this)(keys, config::number_text(value)); }
  void operator()(Keys keys, int value) { (*this)(keys, std::to_string(value)); }
  void operator()(Keys keys, bool value) { (*this)(keys, value ? "true" : "false"); }

 private:
  CuraSettings& out_;
};

void put_machine(Putter& put, const toolpath::PrintSettings& s) {
  const auto& m = s.machine;
  put({"machine_width"}, m.bed_mm[0]);
  put({"machine_depth"}, m.bed_mm[1]);
  put({"machine_height", "gantry_height"}, m.height_mm);
  put({"machine_center_is_zero"}, m.origin_at_centre);
  put({"machine_nozzle_size"}, m.nozzle_mm);
  put({"machine_gcode_flavor"}, "RepRap (Marlin/Sprinter)");
  put({"machine_firmware_retract", "prime_blob_enable", "prime_tower_enable"}, false);
  put({"relative_extrusion"}, m.relative_e);
  put({"material_diameter"}, s.filament.diameter_mm);
  put({"material_print_temperature", "default_material_print_temperature",
       "material_initial_print_temperature", "material_final_print_temperature"},
      s.filament.nozzle_c);
  put({"material_print_temperature_layer_0"}, s.filament.nozzle_first_layer_c);
  put({"material_bed_temperature", "default_material_bed_temperature"}, s.filament.bed_c);
  put({"material_bed_temperature_layer_0"}, s.filament.bed_first_layer_c);
  put({"machine_heated_bed"}, s.filament.bed_c > 0 || s.filament.bed_first_layer_c > 0);
  put({"material_flow", "wall_material_flow", "wall_0_material_flow", "wall_x_material_flow",
       "skin_material_flow", "roofing_material_flow", "infill_material_flow", "skirt_brim_material_flow",
       "support_material_flow", "support_interface_material_flow", "support_roof_material_flow",
       "support_bottom_material_flow"},
      100 * s.filament.flow);
}

/// As many as asked for, and more where those are thinner than asked for.
int skin_layers(int layers, double thickness_mm, double layer_height_mm) {
  constexpr double kRounding = 1e-4;  // of a layer
  return layers == 0
             ? 0
             : std::max(layers, static_cast<int>(std::ceil(thickness_mm / layer_height_mm - kRounding)));
}

void put_shells(Putter& put, const toolpath::SliceSettings& s) {
  put({"layer_height", "infill_sparse_thickness", "support_infill_sparse_thickness"}, s.layer_height_mm);
  put({"layer_height_0"}, s.first_layer_height_mm);
  put({"line_width", "wall_line_width", "wall_line_width_0", "wall_line_width_x", "skin_line_width",
       "infill_line_width", "skirt_brim_line_width", "support_line_width", "support_interface_line_width",
       "support_roof_line_width", "support_bottom_line_width", "roofing_line_width"},
      s.line_width_mm);
  put({"initial_layer_line_width_factor"}, 100 * s.first_layer_line_width_mm / s.line_width_mm);
  put({"wall_line_count"}, s.perimeters);
  put({"wall_thickness"}, s.perimeters * s.line_width_mm);
  put({"outer_inset_first"}, s.external_perimeters_first);
  put({"wall_0_wipe_dist", "infill_wipe_dist", "wall_0_inset"}, 0);
  put({"optimize_wall_printing_order"}, true);
  put({"alternate_extra_perimeter", "fill_outline_gaps"}, false);
  put({"fill_perimeter_gaps"}, "everywhere");
  put({"xy_offset", "hole_xy_offset"}, 0);
  put({"xy_offset_layer_0"}, -s.elephant_foot_mm);
  put({"z_seam_type"}, s.seam == toolpath::SeamPosition::aligned ? "sharpest_corner"
                       : s.seam == toolpath::SeamPosition::rear  ? "back"
                                                                 : "shortest");
  const int top = skin_layers(s.top_layers, s.top_thickness_mm, s.layer_height_mm);
  const int bottom = skin_layers(s.bottom_layers, s.bottom_thickness_mm, s.layer_height_mm);
  put({"top_layers"}, top);
  put({"bottom_layers", "initial_bottom_layers"}, bottom);
  put({"top_thickness"}, top * s.layer_height_mm);
  put({"bottom_thickness"}, bottom * s.layer_height_mm);
  put({"top_bottom_pattern", "top_bottom_pattern_0", "roofing_pattern"}, "zigzag");
  put({"skin_outline_count", "roofing_layer_count"}, 0);
  put({"top_skin_preshrink", "bottom_skin_preshrink", "skin_preshrink", "top_skin_expand_distance",
       "bottom_skin_expand_distance", "expand_skins_expand_distance"},
      s.perimeters * s.line_width_mm);
  put({"skin_overlap_mm", "infill_overlap_mm"}, s.infill_overlap * s.line_width_mm);
  put({"meshfix_maximum_resolution", "meshfix_maximum_travel_resolution"}, std::max(s.resolution_mm, 0.01));
  put({"meshfix_maximum_deviation"}, std::max(s.resolution_mm, 0.001));
  put({"adaptive_layer_height_enabled", "ironing_enabled", "magic_spiralize"}, false);
  put({"slicing_tolerance"}, "middle");
}

void put_infill(Putter& put, const toolpath::SliceSettings& s) {
  using toolpath::InfillPattern;
  const auto pattern = s.infill_pattern;
  put({"infill_pattern"}, pattern == InfillPattern::grid         ? "grid"
                          : pattern == InfillPattern::concentric ? "concentric"
                          : pattern == InfillPattern::gyroid     ? "gyroid"
                          : pattern == InfillPattern::lightning  ? "lightning"
                                                                 : "lines");
  put({"zig_zaggify_infill", "connect_infill_polygons"}, true);
  put({"infill_sparse_density"}, 100 * s.infill_density);
  // A grid's two directions share the density.
  const double directions = pattern == InfillPattern::grid ? 2 : 1;
  put({"infill_line_distance"}, s.infill_density > 0 ? directions * s.line_width_mm / s.infill_density : 0.0);
  const std::string angle = config::number_text(s.infill_angle_deg);
  const std::string crossed = config::number_text(s.infill_angle_deg + 90);
  put({"infill_angles"},
      pattern == InfillPattern::rectilinear ? "[" + angle + "," + crossed + "]" : "[" + angle + "]");
  put({"skin_angles", "roofing_angles"}, "[" + angle + "," + crossed + "]");
  put({"min_infill_area"}, s.min_infill_area_mm2);
  put({"infill_before_walls"}, false);
  put({"gradual_infill_steps", "skin_edge_support_layers", "infill_wall_line_count"}, 0);
  put({"infill_multiplier"}, 1);
}

void put_support(Putter& put, const toolpath::SliceSettings& s) {
  put({"support_enable"}, s.support != toolpath::SupportMode::none);
  put({"support_structure"}, "normal");
  put({"support_type"}, s.support == toolpath::SupportMode::plate ? "buildplate" : "everywhere");
  put({"support_angle"}, s.support_angle_deg);
  put({"support_pattern"}, "zigzag");
  put({"support_wall_count"}, 0);
  put({"support_infill_rate"}, 100 * s.support_density);
  put({"support_line_distance", "support_initial_layer_line_distance"},
      s.support_density > 0 ? s.line_width_mm / s.support_density : 0.0);
  put({"support_z_distance", "support_top_distance", "support_bottom_distance"}, s.support_z_gap_mm);
  put({"support_xy_distance", "support_xy_distance_overhang"}, s.support_xy_gap_mm);
  const bool roof = s.support_interface_layers > 0;
  put({"support_interface_enable", "support_roof_enable"}, roof);
  put({"support_bottom_enable"}, false);
  put({"support_interface_height", "support_roof_height"}, s.support_interface_layers * s.layer_height_mm);
  put({"support_interface_density", "support_roof_density"}, 100 * toolpath::kInterfaceDensity);
  put({"support_roof_line_distance"}, s.line_width_mm / toolpath::kInterfaceDensity);
  put({"support_interface_pattern", "support_roof_pattern"}, "zigzag");
  put({"support_interface_skip_height"}, s.layer_height_mm);
  const bool brim = s.brim_width_mm > 0;
  put({"adhesion_type"}, brim ? "brim" : s.skirt_loops > 0 ? "skirt" : "none");
  put({"skirt_line_count"}, s.skirt_loops);
  put({"skirt_gap"}, s.skirt_gap_mm);
  put({"skirt_brim_minimal_length"}, 0);
  put({"brim_width"}, s.brim_width_mm);
  put({"brim_line_count"}, static_cast<int>(std::ceil(s.brim_width_mm / s.first_layer_line_width_mm)));
}

void put_speeds(Putter& put, const toolpath::PrintSettings& s) {
  const auto& v = s.speed;
  put({"speed_print", "speed_infill"}, v.infill);
  put({"speed_wall", "speed_wall_x"}, v.perimeter);
  put({"speed_wall_0"}, v.external_perimeter);
  put({"speed_topbottom"}, v.solid_infill);
  put({"speed_roofing"}, v.top_solid_infill);
  put({"speed_support", "speed_support_infill", "speed_support_interface", "speed_support_roof",
       "speed_support_bottom"},
      v.support);
  put({"bridge_wall_speed", "bridge_skin_speed"}, v.bridge);
  put({"speed_travel", "speed_travel_layer_0"}, v.travel);
  put({"speed_layer_0", "speed_print_layer_0", "skirt_brim_speed"}, v.first_layer);
  put({"speed_slowdown_layers"}, 1);
  const auto& a = s.acceleration;
  put({"acceleration_enabled"}, a.print > 0);
  if (a.print > 0) {
    put({"acceleration_print", "acceleration_infill", "acceleration_wall", "acceleration_wall_0",
         "acceleration_wall_x", "acceleration_roofing", "acceleration_topbottom", "acceleration_support",
         "acceleration_support_infill", "acceleration_support_interface", "acceleration_support_roof",
         "acceleration_support_bottom"},
        a.print);
    put({"acceleration_layer_0", "acceleration_print_layer_0", "acceleration_skirt_brim"},
        a.first_layer > 0 ? a.first_layer : a.print);
    put({"acceleration_travel", "acceleration_travel_layer_0"}, a.travel > 0 ? a.travel : a.print);
  }
  put({"jerk_enabled"}, false);
}

void put_retraction(Putter& put, const toolpath::PrintSettings& s) {
  const auto& r = s.retract;
  put({"retraction_enable"}, r.length_mm > 0);
  put({"retraction_amount"}, r.length_mm);
  put({"retraction_speed", "retraction_retract_speed"}, r.speed_mm_s);
  put({"retraction_prime_speed"}, r.deretract_speed_mm_s);
  put({"retraction_min_travel"}, r.min_travel_mm);
  put({"retraction_extra_prime_amount", "retraction_extrusion_window", "retraction_combing_max_distance"}, 0);
  put({"retraction_count_max"}, 1000000);
  put({"retract_at_layer_change", "travel_retract_before_outer_wall", "limit_support_retractions"}, false);
  put({"retraction_combing"}, "all");
  put({"retraction_hop_enabled"}, r.lift_mm > 0);
  put({"retraction_hop"}, r.lift_mm);
  const auto& c = s.cooling;
  put({"cool_fan_enabled"}, c.enabled);
  put({"cool_fan_speed", "cool_fan_speed_min"}, c.enabled ? 100 * c.fan_min : 0.0);
  put({"cool_fan_speed_max"}, c.enabled ? 100 * c.fan_max : 0.0);
  put({"cool_fan_speed_0"}, 0);
  put({"cool_fan_full_layer"}, c.fan_off_layers + 1);
  put({"bridge_fan_speed"}, 100 * c.bridge_fan);
  put({"cool_min_layer_time"}, c.enabled ? c.slow_below_s : 0.0);
  put({"cool_min_layer_time_fan_speed_max"}, std::max(c.full_fan_below_s, c.slow_below_s));
  put({"cool_min_speed"}, c.min_speed_mm_s);
}

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

std::string with_new_lines(const std::string& value) {
  std::string out;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const bool escape = value[i] == '\\' && i + 1 < value.size() && value[i + 1] == 'n';
    out += escape ? '\n' : value[i];
    if (escape) ++i;
  }
  return out;
}

}  // namespace

CuraSettings cura_settings(const toolpath::PrintSettings& print) {
  CuraSettings out;
  Putter put(out);
  put_machine(put, print);
  put_shells(put, print.slice);
  put_infill(put, print.slice);
  put_support(put, print.slice);
  put_speeds(put, print);
  put_retraction(put, print);
  return out;
}

CuraSettings cura_start_and_end(const toolpath::PrintSettings& print, const CuraSettings& settings,
                                const mesh::Bounds& placed) {
  toolpath::Placeholders values = toolpath::placeholders(toolpath::Plan{}, print);
  const std::pair<const char*, const char*> known[] = {
      {"nozzle_c", "material_print_temperature"},
      {"nozzle_first_layer_c", "material_print_temperature_layer_0"},
      {"bed_c", "material_bed_temperature"},
      {"bed_first_layer_c", "material_bed_temperature_layer_0"},
      {"layer_height", "layer_height"},
      {"first_layer_height", "layer_height_0"},
      {"line_width", "line_width"}};
  for (const auto& [ours, theirs] : known)
    if (const auto found = settings.find(theirs); found != settings.end()) values[ours] = found->second;
  for (const std::string prefix : {"", "first_layer_"})
    for (const Eigen::Index a : {0, 1}) {
      const std::string axis = a == 0 ? "x" : "y";
      values[prefix + "min_" + axis] = config::number_text(placed.min[a]);
      values[prefix + "max_" + axis] = config::number_text(placed.max[a]);
    }
  values["first_layer_size_x"] = config::number_text(placed.size().x());
  values["first_layer_size_y"] = config::number_text(placed.size().y());
  values["max_z"] = config::number_text(placed.max.z());
  return {{"machine_start_gcode", toolpath::expand(print.machine.start_gcode, values, "start G-code")},
          {"machine_end_gcode", toolpath::expand(print.machine.end_gcode, values, "end G-code")},
          {"material_print_temp_prepend", "false"},
          {"material_bed_temp_prepend", "false"}};
}

std::vector<std::string> cura_arguments(const CuraSettings& settings) {
  std::vector<std::string> out;
  for (const bool extruder : {false, true}) {
    if (extruder) out.emplace_back("-e0");
    for (const auto& [key, value] : settings) {
      out.emplace_back("-s");
      out.push_back(key + "=" + value);
    }
  }
  return out;
}

CuraSettings read_cura_settings(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw config::ConfigError(file.string() + ": cannot be read");
  CuraSettings all, values;
  std::string section;
  std::string* last = nullptr;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    const auto fail = [&](const std::string& what) {
      throw config::ConfigError(file.string() + ":" + std::to_string(number) + ": " + what);
    };
    const std::string text = trimmed(line);
    if (text.empty() || text.front() == '#' || text.front() == ';') continue;
    if (last != nullptr && (line.front() == ' ' || line.front() == '\t')) {
      *last += "\n" + text;
      continue;
    }
    if (text.front() == '[' && text.back() == ']') {
      section = text.substr(1, text.size() - 2);
      last = nullptr;
      continue;
    }
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) fail("'key = value' is wanted");
    const std::string key = trimmed(text.substr(0, equals));
    const std::string value = trimmed(text.substr(equals + 1));
    if (key.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") != std::string::npos)
      fail("'" + key + "' is no setting of Cura's");
    if (value.starts_with('='))
      fail(key + " is a formula, which only Cura itself can compute; write the value it comes to");
    last = &(section == "values" ? values : all)[key];
    *last = with_new_lines(value);
  }
  return values.empty() ? all : values;
}

}  // namespace voidpath::daemon
