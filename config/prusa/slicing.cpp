#include "config/fields.h"
#include "config/prusa/importer.h"
#include "engine/toolpath/bead.h"

#include <cmath>
#include <map>

/// Layers, widths, shells, infill, supports and speeds. Rules of PrusaSlicer 2.5's documentation of its
/// settings.
namespace voidpath::config {

namespace {

/// Automatic widths, in nozzle diameters.
constexpr double kAutoWidth = 1.125;
constexpr double kAutoWidthOfTopAndSupport = 1.0;
/// A loop no longer than a circle of 6.5 mm radius is small there.
constexpr double kSmallPerimeter_mm = 40.84;
/// Widths nearer than this are one.
constexpr double kSameWidth_mm = 0.005;

/// A width of 0 is the general one, and that, if 0, automatic; a share is of the layer's height.
std::optional<double> width(PrusaImporter& in, const std::string& key, const PrusaLayers& layers,
                            std::optional<double> height, double automatic) {
  auto amount = in.amount(key);
  if (!amount || amount->value == 0) amount = in.amount("extrusion_width");
  if (!amount) return std::nullopt;
  if (amount->value == 0) return layers.nozzle ? std::optional(automatic * *layers.nozzle) : std::nullopt;
  if (amount->percent && !height) return std::nullopt;
  return amount->of(height.value_or(0));
}

/// PrusaSlicer adds layers until the thickness is reached; where our profiles know no thickness, the count
/// does it.
void put_skin(PrusaImporter& in, const std::string& side, std::optional<double> height) {
  const auto layers = in.number(side + "_solid_layers");
  const auto thickness = in.number(side + "_solid_min_thickness");
  if (!layers) return;
  if (in.put("slice." + side + "_thickness_mm", thickness) || !thickness || !height || *layers == 0) {
    in.put("slice." + side + "_layers", layers);
    return;
  }
  const double wanted = std::ceil(*thickness / *height - 1e-4);
  in.put("slice." + side + "_layers", std::max(*layers, wanted));
  if (wanted > *layers)
    in.note(side + "_solid_min_thickness = " + millimetres(*thickness) + " takes " + number_text(wanted) +
            " layers, more than " + number_text(*layers));
}

void put_pattern(PrusaImporter& in) {
  const auto pattern = in.word("fill_pattern");
  if (!pattern) return;
  const std::map<std::string, std::string> same = {{"rectilinear", "rectilinear"},
                                                   {"grid", "grid"},
                                                   {"gyroid", "gyroid"},
                                                   {"concentric", "concentric"},
                                                   {"lightning", "lightning"}};
  const std::map<std::string, std::string> near = {{"line", "rectilinear"},
                                                   {"alignedrectilinear", "rectilinear"},
                                                   {"monotonic", "rectilinear"},
                                                   {"monotoniclines", "rectilinear"},
                                                   {"zigzag", "rectilinear"},
                                                   {"3dhoneycomb", "gyroid"},
                                                   {"cubic", "grid"},
                                                   {"adaptivecubic", "grid"},
                                                   {"supportcubic", "grid"},
                                                   {"stars", "grid"},
                                                   {"triangles", "grid"},
                                                   {"honeycomb", "grid"},
                                                   {"hilbertcurve", "rectilinear"},
                                                   {"archimedeanchords", "concentric"},
                                                   {"octagramspiral", "concentric"}};
  if (const auto found = same.find(*pattern); found != same.end()) {
    in.put_yaml("slice.infill_pattern", found->second);
    return;
  }
  const auto found = near.find(*pattern);
  if (found == near.end()) {
    in.leave_out("fill_pattern = " + *pattern);
    return;
  }
  in.put_yaml("slice.infill_pattern", found->second);
  in.approximated("fill_pattern = " + *pattern + ": printed as " + found->second);
}

void put_solid_pattern(PrusaImporter& in, const std::string& theirs, const std::string& ours) {
  const auto pattern = in.word(theirs);
  if (!pattern) return;
  in.put_yaml(ours, *pattern == "concentric" ? "concentric" : "rectilinear");
  if (*pattern != "concentric" && *pattern != "rectilinear" && !pattern->starts_with("monotonic") &&
      *pattern != "alignedrectilinear")
    in.approximated(theirs + " = " + *pattern + ": printed as rectilinear");
}

/// Top and bottom were one setting once, under two names.
void put_solid_patterns(PrusaImporter& in) {
  for (const std::string side : {"top", "bottom"}) {
    const std::string ours = side == "top" ? "slice.top_pattern" : "slice.solid_pattern";
    for (const std::string theirs : {"external_fill_pattern", "solid_fill_pattern"})
      put_solid_pattern(in, theirs, ours);
    put_solid_pattern(in, side + "_fill_pattern", ours);
  }
}

void put_seam(PrusaImporter& in) {
  const auto seam = in.word("seam_position");
  if (!seam) return;
  const bool same = *seam == "nearest" || *seam == "aligned" || *seam == "rear";
  in.put_yaml("slice.seam", same ? *seam : "nearest");
  if (!same) in.approximated("seam_position = " + *seam + ": seams go to the nearest corner");
}

void put_raft(PrusaImporter& in) {
  const auto layers = in.number("raft_layers");
  in.put("slice.raft_layers", layers);
  in.put("slice.raft_gap_mm", in.number("raft_contact_distance"));
  in.put("slice.raft_margin_mm", in.number("raft_expansion"));
  if (layers.value_or(0) > 0) return;
  for (const char* only_of_rafts : {"raft_first_layer_density", "raft_first_layer_expansion",
                                    "first_layer_acceleration_over_raft", "first_layer_speed_over_raft"})
    in.use(only_of_rafts);
}

void put_adhesion(PrusaImporter& in) {
  in.put("slice.skirt_loops", in.number("skirts"));
  in.put("slice.skirt_gap_mm", in.number("skirt_distance"));
  in.put("slice.skirt_layers", in.number("skirt_height"));
  const auto type = in.word("brim_type");
  const auto brim = in.number("brim_width");
  if (!brim) return;
  in.put("slice.brim_width_mm", type && *type == "no_brim" ? 0.0 : *brim);
  in.put("slice.brim_gap_mm", in.number("brim_separation"));
  if (type && *type != "no_brim")
    in.put_yaml("slice.brim_type", *type == "inner_only"        ? "inner"
                                   : *type == "outer_and_inner" ? "both"
                                                                : "outer");
}

/// Columns and snug columns are ours; trees have other names for the same lengths.
void put_support_style(PrusaImporter& in) {
  const auto style = in.word("support_material_style");
  if (!style) return;
  const bool tree = *style == "organic" || *style == "tree";
  in.put_yaml("slice.support_style", tree ? "tree" : "grid");
  if (!tree && *style != "grid") in.approximated("support_material_style = " + *style + ": printed as grid");
  const std::pair<const char*, const char*> lengths[] = {
      {"support_tree_tip_diameter", "slice.tree_tip_diameter_mm"},
      {"support_tree_angle", "slice.tree_branch_angle_deg"}};
  for (const auto& [theirs, ours] : lengths) in.put(ours, in.number(theirs));
  for (const char* other : {"support_tree_angle_slow", "support_tree_branch_diameter",
                            "support_tree_branch_diameter_angle", "support_tree_branch_diameter_double_wall",
                            "support_tree_branch_distance", "support_tree_top_rate"}) {
    if (tree && in.has(other)) in.leave_out(std::string(other) + " = " + in.word(other).value_or(""));
    in.use(other);
  }
}

/// There the speeds are by how much of the bead overlaps the wall below, here by how much does not.
void put_overhang_speeds(PrusaImporter& in, std::optional<double> perimeter) {
  const auto on = in.flag("enable_dynamic_overhang_speeds");
  const std::pair<const char*, const char*> speeds[] = {{"overhang_speed_3", "speed.overhang_25_mm_s"},
                                                        {"overhang_speed_2", "speed.overhang_50_mm_s"},
                                                        {"overhang_speed_1", "speed.overhang_75_mm_s"}};
  for (const auto& [theirs, ours] : speeds) {
    const auto value = in.part_of(theirs, perimeter);
    if (on) in.put(ours, *on ? value : std::optional(0.0));
  }
  const auto none = in.word("overhang_speed_0");
  if (on && *on && none)
    in.approximated("overhang_speed_0 = " + *none + ": a wall all over air keeps to overhang_speed_1 here");
}

}  // namespace

PrusaLayers import_layers(PrusaImporter& in) {
  PrusaLayers l;
  in.use("extrusion_width");  // of those below that say nothing themselves
  l.height = in.number("layer_height");
  l.first = in.part_of("first_layer_height", l.height);
  l.nozzle = in.number("nozzle_diameter");
  in.put("slice.layer_height_mm", l.height);
  in.put("slice.first_layer_height_mm", l.first);
  in.put("machine.nozzle_mm", l.nozzle);
  l.width = width(in, "perimeter_extrusion_width", l, l.height, kAutoWidth);
  in.put("slice.line_width_mm", l.width);
  const auto first = in.amount("first_layer_extrusion_width");
  if (first && first->value > 0)
    in.put("slice.first_layer_line_width_mm", in.part_of("first_layer_extrusion_width", l.first));
  else
    in.put("slice.first_layer_line_width_mm", width(in, "perimeter_extrusion_width", l, l.first, kAutoWidth));
  const std::pair<const char*, double> others[] = {
      {"external_perimeter_extrusion_width", kAutoWidth},
      {"infill_extrusion_width", kAutoWidth},
      {"solid_infill_extrusion_width", kAutoWidth},
      {"top_infill_extrusion_width", kAutoWidthOfTopAndSupport},
      {"support_material_extrusion_width", kAutoWidthOfTopAndSupport}};
  for (const auto& [key, automatic] : others) {
    const auto theirs = width(in, key, l, l.height, automatic);
    if (theirs && l.width && std::abs(*theirs - *l.width) > kSameWidth_mm)
      in.approximated(std::string(key) + ": " + millimetres(*theirs) + " there; every line is " +
                      millimetres(*l.width) + " wide here, as its perimeters are");
  }
  return l;
}

void import_shells(PrusaImporter& in, const PrusaLayers& layers) {
  in.put("slice.perimeters", in.number("perimeters"));
  put_skin(in, "top", layers.height);
  put_skin(in, "bottom", layers.height);
  in.put("slice.infill_density", in.part_of("fill_density", 1.0));
  put_pattern(in);
  in.put("slice.infill_angle_deg", in.number("fill_angle"));
  if (const auto overlap = in.amount("infill_overlap"); overlap && (overlap->percent || layers.width))
    in.put("slice.infill_overlap", overlap->percent ? overlap->value / 100 : overlap->value / *layers.width);
  in.put_flag("slice.external_perimeters_first", in.flag("external_perimeters_first"));
  // How far a line goes on along the wall to the next one; 0 leaves them apart.
  const auto anchor = in.amount("infill_anchor_max");
  if (anchor && anchor->value == 0) in.leave_out("infill_anchor_max = 0 (lines of infill are joined)");
  in.use("infill_anchor");
  put_seam(in);
  put_adhesion(in);
  put_raft(in);
  if (const auto growth = in.number("xy_size_compensation")) {
    in.put("slice.xy_compensation_mm", *growth);
    in.put("slice.hole_compensation_mm", 0.0 - *growth);  // there one number grows all outlines into the air
  }
  in.put_flag("slice.spiral_vase", in.flag("spiral_vase"));
  in.put("slice.elephant_foot_mm", in.number("elefant_foot_compensation"));
  in.put("slice.resolution_mm", in.number("gcode_resolution"));
  in.put("slice.min_infill_area_mm2", in.number("solid_infill_below_area"));
  in.put("slice.infill_every_layers", in.number("infill_every_layers"));
  in.put("slice.bridge_flow", in.number("bridge_flow_ratio"));
  put_solid_patterns(in);
}

void import_supports(PrusaImporter& in, const PrusaLayers& layers) {
  const auto on = in.flag("support_material");
  const auto automatic = in.flag("support_material_auto");
  const auto plate = in.flag("support_material_buildplate_only");
  if (on) {
    const bool by_itself = *on && automatic.value_or(true);
    in.put_yaml("slice.support", !by_itself ? "none" : plate.value_or(false) ? "plate" : "everywhere");
    if (*on && !by_itself)
      in.approximated(
          "support_material_auto = 0: enforced areas are not in the configuration, so nothing is supported");
  }
  if (const auto threshold = in.number("support_material_threshold")) {
    // Counted from the horizontal there. 0 is automatic: a wall's bead that hangs over air by half of it.
    if (*threshold > 0) {
      in.put("slice.support_angle_deg", 90 - *threshold);
    } else if (layers.height && layers.width) {
      const double angle = std::atan2(*layers.width / 2, *layers.height) * 180 / 3.14159265358979;
      in.put("slice.support_angle_deg", std::round(angle));
      in.approximated("support_material_threshold = 0 (automatic): supported is what leans out more than " +
                      number_text(std::round(angle)) +
                      " degrees from the vertical, half a line's width a layer");
    }
  }
  if (const auto spacing = in.number("support_material_spacing"); spacing && layers.height && layers.width) {
    const double line = toolpath::bead_spacing_mm(*layers.width, *layers.height);
    in.put("slice.support_density", std::min(1.0, line / (*spacing + line)));
  }
  in.put("slice.support_xy_gap_mm", in.part_of("support_material_xy_spacing", layers.width));
  in.put("slice.support_z_gap_mm", in.number("support_material_contact_distance"));
  in.put("slice.support_interface_layers", in.number("support_material_interface_layers"));
  put_support_style(in);
}

void import_speeds(PrusaImporter& in) {
  const auto most = in.number("max_print_speed");
  const auto speed = [&](const std::string& key, std::optional<double> whole) {
    const auto value = in.part_of(key, whole);
    if (!value || *value > 0) return value;
    if (most) in.approximated(key + " = 0 (automatic): max_print_speed, " + number_text(*most) + " mm/s");
    return most;
  };
  const auto perimeter = speed("perimeter_speed", std::nullopt);
  const auto infill = speed("infill_speed", std::nullopt);
  const auto solid = speed("solid_infill_speed", infill);
  in.put("speed.perimeter_mm_s", perimeter);
  in.put("speed.external_perimeter_mm_s", speed("external_perimeter_speed", perimeter));
  put_overhang_speeds(in, in.part_of("external_perimeter_speed", perimeter));
  in.put("speed.infill_mm_s", infill);
  in.put("speed.solid_infill_mm_s", solid);
  in.put("speed.top_solid_infill_mm_s", speed("top_solid_infill_speed", solid));
  in.put("speed.support_mm_s", speed("support_material_speed", std::nullopt));
  const auto bridge = speed("bridge_speed", std::nullopt);
  in.put("speed.bridge_mm_s", bridge);
  in.put("speed.internal_bridge_mm_s", bridge);
  in.put("speed.gap_fill_mm_s", speed("gap_fill_speed", perimeter));
  in.put("speed.travel_mm_s", in.number("travel_speed"));
  if (const auto small = speed("small_perimeter_speed", perimeter)) {
    in.put("speed.small_perimeter_mm_s", small);
    in.put("slice.small_perimeter_length_mm", kSmallPerimeter_mm);
  }
  if (const auto first = in.amount("first_layer_speed")) {
    in.put("speed.first_layer_mm_s", in.part_of("first_layer_speed", perimeter));
    if (first->percent)
      in.approximated("first_layer_speed = " + number_text(first->value) +
                      " %: of each line's own speed there; of the perimeters' here");
  }
  const auto print = in.number("default_acceleration");
  in.put("acceleration.print_mm_s2", print);
  in.put("acceleration.first_layer_mm_s2", in.number("first_layer_acceleration"));
  for (const std::string feature :
       {"perimeter", "external_perimeter", "infill", "solid_infill", "top_solid_infill", "bridge"})
    in.put("acceleration." + feature + "_mm_s2", in.number(feature + "_acceleration"));
  in.put("acceleration.travel_mm_s2", in.number("travel_acceleration"));
}

}  // namespace voidpath::config
