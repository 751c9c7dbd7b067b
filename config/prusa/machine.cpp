#include "config/config.h"
#include "config/fields.h"
#include "config/prusa/gcode.h"
#include "config/prusa/importer.h"

#include <algorithm>
#include <array>
#include <cmath>

/// Filament, cooling, retraction, and the machine with its G-code.
namespace voidpath::config {

namespace {

/// Bed corners nearer than this lie at the origin.
constexpr double kAtOrigin_mm = 0.01;

void import_cooling(PrusaImporter& in) {
  const auto automatic = in.flag("cooling");
  const auto always = in.flag("fan_always_on");
  const auto least = in.part_of("min_fan_speed", std::nullopt);
  const auto most = in.part_of("max_fan_speed", std::nullopt);
  if (automatic && always && least && most) {
    const bool on = *automatic || *always;
    in.put_flag("cooling.enabled", on);
    in.put("cooling.fan_min", *always ? *least / 100 : 0.0);
    in.put("cooling.fan_max", (*automatic ? *most : *least) / 100);
  }
  const double never = 0;
  const auto slow = in.number("slowdown_below_layer_time");
  const auto full = in.number("fan_below_layer_time");
  in.put("cooling.slow_below_s", automatic && !*automatic && slow ? std::optional(never) : slow);
  in.put("cooling.full_fan_below_s", automatic && !*automatic && full ? std::optional(never) : full);
  in.put("cooling.min_speed_mm_s", in.number("min_print_speed"));
  if (const auto bridge = in.number("bridge_fan_speed")) in.put("cooling.bridge_fan", *bridge / 100);
  in.put("cooling.fan_off_layers", in.number("disable_fan_first_layers"));
  in.put("cooling.full_fan_at_layer", in.number("full_fan_speed_layer"));
}

void import_retraction(PrusaImporter& in) {
  // A filament's own value goes before the printer's.
  const auto retract = [&](const std::string& key) {
    const auto own = in.number("filament_" + key);
    const auto general = in.number(key);
    return own ? own : general;
  };
  const auto length = retract("retract_length");
  const auto speed = retract("retract_speed");
  const auto back = retract("deretract_speed");
  in.put("retract.length_mm", length);
  in.put("retract.speed_mm_s", speed);
  in.put("retract.deretract_speed_mm_s", back && *back > 0 ? back : speed);
  in.put("retract.lift_mm", retract("retract_lift"));
  in.put("retract.min_travel_mm", retract("retract_before_travel"));
  const auto own_wipe = in.flag("filament_wipe");
  const auto wipe = in.flag("wipe");
  in.put_flag("retract.wipe", own_wipe ? own_wipe : wipe);
  if (!own_wipe.value_or(wipe.value_or(false)))
    for (const char* only_of_wipes : {"retract_before_wipe", "filament_retract_before_wipe"})
      in.use(only_of_wipes);
  in.put_flag("retract.avoid_crossing_perimeters", in.flag("avoid_crossing_perimeters"));
  if (!in.flag("avoid_crossing_perimeters").value_or(false)) in.use("avoid_crossing_perimeters_max_detour");
  if (const auto firmware = in.flag("use_firmware_retraction"); firmware && *firmware)
    in.leave_out("use_firmware_retraction = 1 (retraction is written as E moves of retract_length)");
}

/// The polygon's box; ours are rectangles that begin at, or lie around, the origin.
void import_bed(PrusaImporter& in) {
  const auto shape = in.word("bed_shape");
  if (!shape) return;
  std::array<double, 2> min{1e9, 1e9}, max{-1e9, -1e9};
  std::size_t corners = 0;
  for (std::size_t begin = 0; begin < shape->size(); ++corners) {
    const std::size_t comma = std::min(shape->find(',', begin), shape->size());
    const std::string corner = shape->substr(begin, comma - begin);
    const std::size_t x = corner.find('x');
    if (x == std::string::npos)
      throw ConfigError("bed_shape = " + *shape + ": corners such as 0x0,250x0 are wanted");
    try {
      const double at[2] = {parse_number(corner.substr(0, x)), parse_number(corner.substr(x + 1))};
      for (std::size_t a = 0; a < 2; ++a) {
        min[a] = std::min(min[a], at[a]);
        max[a] = std::max(max[a], at[a]);
      }
    } catch (const std::invalid_argument& e) {
      throw ConfigError("bed_shape = " + *shape + ": " + e.what());
    }
    begin = comma + 1;
  }
  const bool centred = std::abs(min[0] + max[0]) < kAtOrigin_mm && std::abs(min[1] + max[1]) < kAtOrigin_mm;
  const bool cornered = std::abs(min[0]) < kAtOrigin_mm && std::abs(min[1]) < kAtOrigin_mm;
  // What lies before the origin is lost, so that nothing is printed beyond the bed.
  const double x = centred || cornered ? max[0] - min[0] : max[0];
  const double y = centred || cornered ? max[1] - min[1] : max[1];
  in.put_yaml("machine.bed_mm", "[" + number_text(x) + ", " + number_text(y) + "]");
  in.put_flag("machine.origin_at_centre", centred);
  if (!centred && !cornered)
    in.approximated("bed_shape = " + *shape + ": only what lies beyond the origin is used, " +
                    number_text(x) + " x " + number_text(y) + " mm");
  else if (corners != 4)
    in.approximated("bed_shape: " + std::to_string(corners) + " corners; used as a rectangle of " +
                    number_text(x) + " x " + number_text(y) + " mm, so mind its edges");
}

void put_axes(PrusaImporter& in, const std::string& ours, const std::string& prefix) {
  std::string list;
  for (const char* axis : {"x", "y", "z", "e"})
    if (const auto value = in.number(prefix + axis))
      list += (list.empty() ? "" : ", ") + (std::string(axis) + ": ") + number_text(*value);
  if (!list.empty()) in.put_yaml(ours, "{" + list + "}");
}

void import_limits(PrusaImporter& in) {
  const auto usage = in.word("machine_limits_usage");
  if (usage && *usage == "ignore") {
    for (const auto& [key, value] : in.values())
      if (key.starts_with("machine_max_")) in.use(key);
    in.note(
        "machine_limits_usage = ignore: the machine's limits in the file are not used; set machine: from "
        "what M503 prints");
    return;
  }
  if (usage && *usage == "emit_to_gcode")
    in.approximated(
        "machine_limits_usage = emit_to_gcode: the limits are used for planning, but not sent to the "
        "printer");
  put_axes(in, "machine.max_speed_mm_s", "machine_max_feedrate_");
  put_axes(in, "machine.max_acceleration_mm_s2", "machine_max_acceleration_");
  put_axes(in, "machine.jerk_mm_s", "machine_max_jerk_");
  std::string list;
  for (const auto& [ours, theirs] :
       {std::pair{"print", "extruding"}, {"retract", "retracting"}, {"travel", "travel"}})
    if (const auto value = in.number(std::string("machine_max_acceleration_") + theirs); value && *value > 0)
      list += (list.empty() ? "" : ", ") + (std::string(ours) + ": ") + number_text(*value);
  if (!list.empty()) in.put_yaml("machine.acceleration_mm_s2", "{" + list + "}");
}

/// Whether a command of these numbers stands outside of a comment.
bool commands(const std::string& gcode, std::initializer_list<const char*> wanted) {
  for (std::size_t begin = 0; begin < gcode.size();) {
    const std::size_t end = std::min(gcode.find('\n', begin), gcode.size());
    const std::string line = gcode.substr(begin, end - begin);
    const std::size_t first = std::min(line.find_first_not_of(" \t"), line.size());
    const std::string command =
        line.substr(first, std::min(line.find_first_of(" \t;", first), line.size()) - first);
    for (const char* one : wanted)
      if (command == one) return true;
    begin = end + 1;
  }
  return false;
}

std::string translated(PrusaImporter& in, const std::string& key, const std::string& gcode) {
  const TranslatedGcode t = translate_gcode(gcode, in.values());
  for (const std::string& line : t.left_out) in.leave_out(key + ": the line \"" + line + "\"");
  for (const std::string& constant : t.constants)
    in.note(key + ": " + constant + ", as the file says it now");
  return t.text;
}

void import_gcode(PrusaImporter& in) {
  const auto first_text = [&](const std::string& key) {
    const auto all = in.word(key);
    const auto list = all ? text_list(*all) : std::vector<std::string>{};
    return list.empty() ? std::string() : list.front();
  };
  if (in.has("start_gcode")) {
    std::string start = translated(in, "start_gcode", unescaped(in.word("start_gcode").value_or("")));
    start += translated(in, "start_filament_gcode", first_text("start_filament_gcode"));
    // PrusaSlicer heats by itself where the G-code does not say it.
    const bool emits = in.flag("autoemit_temperature_commands").value_or(true);
    if (emits && !commands(start, {"M104", "M109"}))
      start = "M104 S{nozzle_first_layer_c}\n" + start + "M109 S{nozzle_first_layer_c}\n";
    if (emits && !commands(start, {"M140", "M190"})) start = "M190 S{bed_first_layer_c}\n" + start;
    in.put_text("gcode.start", start);
  }
  if (in.has("end_gcode"))
    in.put_text("gcode.end", translated(in, "end_filament_gcode", first_text("end_filament_gcode")) +
                                 translated(in, "end_gcode", unescaped(in.word("end_gcode").value_or(""))));
  if (const auto flavour = in.word("gcode_flavor"); flavour && *flavour != "marlin" && *flavour != "marlin2")
    in.approximated("gcode_flavor = " + *flavour + ": the G-code is Marlin's");
}

/// Sizes divided by commas, each with a format of its own in newer files.
void import_thumbnails(PrusaImporter& in) {
  const auto format = in.word("thumbnails_format");
  if (!in.has("thumbnails")) return;
  const std::string sizes = in.word("thumbnails").value_or("");
  std::string list, others;
  for (std::size_t i = 0; i < sizes.size();) {
    const std::size_t end = std::min(sizes.find(',', i), sizes.size());
    const std::size_t from = std::min(sizes.find_first_not_of(' ', i), end);
    const std::string each = sizes.substr(from, end - from);
    const std::size_t slash = each.find('/');
    const std::string made = slash != std::string::npos ? each.substr(slash + 1) : format.value_or("PNG");
    if (made != "PNG") others = made;
    list += (list.empty() ? "" : ", ") + yaml_scalar(each.substr(0, slash));
    i = end + 1;
  }
  in.put_yaml("machine.thumbnails", "[" + list + "]");
  if (!others.empty()) in.approximated("thumbnails_format = " + others + ": pictures are PNG");
}

}  // namespace

void import_filament(PrusaImporter& in) {
  const auto id = in.word("filament_settings_id");
  const auto type = in.word("filament_type");
  if (type)
    in.put_text("filament.name", text_list(*type).front());
  else if (id)
    in.put_text("filament.name", text_list(*id).front());
  in.put("filament.diameter_mm", in.number("filament_diameter"));
  if (const auto density = in.number("filament_density"); density && *density > 0)
    in.put("filament.density_g_cm3", density);
  in.put("filament.flow", in.number("extrusion_multiplier"));
  const auto nozzle = in.number("temperature");
  const auto bed = in.number("bed_temperature");
  in.put("filament.nozzle_c", nozzle);
  in.put("filament.nozzle_first_layer_c", in.number("first_layer_temperature"));
  in.put("filament.bed_c", bed);
  in.put("filament.bed_first_layer_c", in.number("first_layer_bed_temperature"));
  const auto flow = in.number("filament_max_volumetric_speed");
  const auto most = in.number("max_volumetric_speed");
  if (flow || most) {
    // 0 is no limit; of two the lower one.
    const double a = flow.value_or(0), b = most.value_or(0);
    in.put("filament.max_flow_mm3_s", a > 0 && b > 0 ? std::min(a, b) : std::max(a, b));
  }
  import_cooling(in);
  import_retraction(in);
}

void import_machine(PrusaImporter& in) {
  const auto id = in.word("printer_settings_id");
  const auto model = in.word("printer_model");
  if (model)
    in.put_text("machine.name", *model);
  else if (id)
    in.put_text("machine.name", *id);
  import_bed(in);
  in.put("machine.height_mm", in.number("max_print_height"));
  in.put_flag("machine.relative_e", in.flag("use_relative_e_distances"));
  if (const auto z = in.number("z_offset"); z && *z != 0)
    in.leave_out("z_offset = " + number_text(*z) + " (set it in the printer: M851)");
  in.put_flag("machine.progress", in.flag("remaining_times"));
  if (const auto arcs = in.word("arc_fitting")) in.put_flag("machine.arcs", *arcs == "emit_center");
  import_thumbnails(in);
  import_limits(in);
  import_gcode(in);
}

}  // namespace voidpath::config
