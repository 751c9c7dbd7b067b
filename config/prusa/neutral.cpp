#include "config/prusa/import.h"

#include <map>
#include <set>
#include <string_view>

namespace voidpath::config {

namespace {

/// Names, prices, pictures, windows, and numbers that only matter with a second extruder or with another
/// setting that is listed by itself: nothing of them is in a print of one part with one extruder.
const std::set<std::string_view> kNeverMatters = {"clip_multipart_objects",
                                                  "color_change_gcode",
                                                  "colorprint_heights",
                                                  "compatible_printers",
                                                  "compatible_printers_condition",
                                                  "compatible_printers_condition_cummulative",
                                                  "compatible_prints",
                                                  "compatible_prints_condition",
                                                  "compatible_prints_condition_cummulative",
                                                  "cooling_tube_length",
                                                  "cooling_tube_retraction",
                                                  "default_filament_profile",
                                                  "default_print_profile",
                                                  "duplicate_distance",
                                                  "extra_loading_move",
                                                  "extruder_clearance_height",
                                                  "extruder_clearance_radius",
                                                  "extruder_colour",
                                                  "extrusion_axis",
                                                  "filament_colour",
                                                  "filament_cooling_final_speed",
                                                  "filament_cooling_initial_speed",
                                                  "filament_cooling_moves",
                                                  "filament_cost",
                                                  "filament_load_time",
                                                  "filament_loading_speed",
                                                  "filament_loading_speed_start",
                                                  "filament_minimal_purge_on_wipe_tower",
                                                  "filament_notes",
                                                  "filament_ramming_parameters",
                                                  "filament_spool_weight",
                                                  "filament_toolchange_delay",
                                                  "filament_unload_time",
                                                  "filament_unloading_speed",
                                                  "filament_unloading_speed_start",
                                                  "filament_vendor",
                                                  "fuzzy_skin_point_dist",
                                                  "fuzzy_skin_thickness",
                                                  "gcode_comments",
                                                  "gcode_label_objects",
                                                  "high_current_on_filament_swap",
                                                  "host_type",
                                                  "inherits",
                                                  "inherits_cummulative",
                                                  "inherits_group",
                                                  "infill_extruder",
                                                  "ironing_flowrate",
                                                  "ironing_spacing",
                                                  "ironing_speed",
                                                  "ironing_type",
                                                  "max_layer_height",
                                                  "min_layer_height",
                                                  "mmu_segmented_region_max_width",
                                                  "notes",
                                                  "output_filename_format",
                                                  "parking_pos_retraction",
                                                  "pause_print_gcode",
                                                  "perimeter_extruder",
                                                  "physical_printer_settings_id",
                                                  "print_host",
                                                  "print_settings_id",
                                                  "filament_settings_id",
                                                  "printer_notes",
                                                  "printer_settings_id",
                                                  "printer_variant",
                                                  "printer_vendor",
                                                  "printhost_apikey",
                                                  "printhost_cafile",

                                                  "resolution",
                                                  "retract_length_toolchange",
                                                  "retract_restart_extra_toolchange",
                                                  "silent_mode",
                                                  "single_extruder_multi_material",
                                                  "single_extruder_multi_material_priming",
                                                  "slice_closing_radius",
                                                  "solid_infill_extruder",
                                                  "standby_temperature_delta",
                                                  "support_material_closing_radius",
                                                  "support_material_extruder",
                                                  "support_material_interface_extruder",
                                                  "template_custom_gcode",
                                                  "threads",
                                                  "toolchange_gcode",
                                                  "variable_layer_height",
                                                  "wipe_into_infill",
                                                  "wipe_into_objects",
                                                  "wipe_tower_bridging",
                                                  "wipe_tower_brim_width",
                                                  "wipe_tower_no_sparse_layers",
                                                  "wipe_tower_rotation_angle",
                                                  "wipe_tower_width",
                                                  "wipe_tower_x",
                                                  "wipe_tower_y",
                                                  "wiping_volumes_extruders",
                                                  "wiping_volumes_matrix",
                                                  "before_layer_gcode_comment",
                                                  "binary_gcode",
                                                  "bed_custom_model",
                                                  "bed_custom_texture",
                                                  "support_material_synchronize_layers",
                                                  "min_bead_width",
                                                  "min_feature_size",
                                                  "wall_distribution_count",
                                                  "wall_transition_angle",
                                                  "wall_transition_filter_deviation",
                                                  "wall_transition_length",
                                                  "filament_soluble",
                                                  "filament_abrasive"};

/// Settings whose effect is missing here unless they have one of these values, divided by |.
const std::map<std::string_view, std::string_view> kNeutral = {
    {"avoid_crossing_perimeters_max_detour", "0|0%"},
    {"before_layer_gcode", ""},
    {"between_objects_gcode", ""},
    {"bridge_angle", "0"},
    {"complete_objects", "0"},
    {"dont_support_bridges", "1"},
    {"draft_shield", "disabled|0"},
    {"ensure_vertical_shell_thickness", "1|enabled"},
    {"extra_perimeters", "0"},
    {"extra_perimeters_on_overhangs", "0"},
    {"extruder_offset", "0x0"},
    {"fuzzy_skin", "none"},
    {"gap_fill_enabled", "1"},
    {"gcode_substitutions", ""},
    {"infill_first", "0"},
    {"infill_only_where_needed", "0"},
    {"interface_shells", "0"},
    {"ironing", "0"},
    {"layer_gcode",
     "|G92 E0|;AFTER_LAYER_CHANGE|;AFTER_LAYER_CHANGE\\n;[layer_z]|;AFTER_LAYER_CHANGE\\n;[layer_z]\\n\\n"},
    {"machine_min_extruding_rate", "0"},
    {"machine_min_travel_rate", "0"},
    {"max_volumetric_extrusion_rate_slope_negative", "0"},
    {"max_volumetric_extrusion_rate_slope_positive", "0"},
    {"min_skirt_length", "0"},
    {"only_retract_when_crossing_perimeters", "0"},
    {"ooze_prevention", "0"},
    {"overhangs", "1"},
    {"perimeter_generator", "arachne|classic"},
    {"post_process", "|\"\""},
    {"retract_before_wipe", "0%|0"},
    {"retract_layer_change", "0"},
    {"retract_lift_above", "0"},
    {"retract_lift_below", "0"},
    {"retract_restart_extra", "0"},
    {"slicing_mode", "regular"},
    {"solid_infill_every_layers", "0"},
    {"support_material_angle", "0"},
    {"support_material_bottom_contact_distance", "0"},
    {"support_material_bottom_interface_layers", "0"},
    {"support_material_enforce_layers", "0"},
    {"support_material_interface_contact_loops", "0"},
    {"support_material_interface_pattern", "auto|rectilinear|monotonic"},
    {"support_material_interface_spacing", "0"},
    {"support_material_interface_speed", "100%|0"},
    {"support_material_pattern", "rectilinear"},
    {"support_material_style", "grid|snug"},
    {"support_material_with_sheath", "0"},
    {"thick_bridges", "1"},
    {"thin_walls", "1|0"},
    {"travel_speed_z", "0"},
    {"use_volumetric_e", "0"},
    {"wipe_tower", "0"}};

bool one_of(std::string_view all, std::string_view value) {
  for (std::size_t begin = 0;;) {
    const std::size_t bar = all.find('|', begin);
    if (all.substr(begin, bar == std::string_view::npos ? bar : bar - begin) == value) return true;
    if (bar == std::string_view::npos) return false;
    begin = bar + 1;
  }
}

}  // namespace

bool is_neutral(const std::string& key, const std::string& value) {
  if (kNeverMatters.contains(key)) return true;
  if (value == "nil") return true;  // a filament that leaves it to the printer
  // Multiplied for extruders and modes: one value, as far as we print.
  const std::string first = value.substr(0, value.find(','));
  const auto found = kNeutral.find(key);
  return found != kNeutral.end() && (one_of(found->second, value) || one_of(found->second, first));
}

}  // namespace voidpath::config
