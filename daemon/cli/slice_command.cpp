#include "daemon/cli/flags.h"
#include "daemon/cli/offline.h"
#include "daemon/cli/x3g_output.h"
#include "daemon/slicer/foreign.h"

#include <chrono>
#include <cstdio>
#include <iostream>

#include <nlohmann/json.hpp>

namespace voidpath::cli {

namespace {

/// As a job of the first printer would get it.
std::filesystem::path own_profile(const config::DaemonConfig& config, const std::string& slicer,
                                  const std::string& given) {
  if (!given.empty()) return given;
  return config.printers.empty() || slicer != config.slicer.name ? std::filesystem::path()
                                                                 : config.printers.front().slicer_profile;
}

}  // namespace

int slice_command(const std::vector<std::string>& args) {
  CLI::App app("Slices a model to G-code, turned to the orientation that prints fastest", "slice");
  CommonFlags common;
  OrientFlags orient;
  std::string model, out, direction;
  std::string slicer, slicer_profile;
  bool as_delivered = false;
  app.add_option("model", model, "STL, OBJ or 3MF")->required();
  app.add_option("-o,--out", out, "the G-code file to write; FILE.x3g: for a MakerBot's card")->required();
  add_common(app, common);
  add_orient(app, orient);
  auto* keep = app.add_flag("--as-delivered", as_delivered, "does not turn the part");
  app.add_option("--direction", direction, "x,y,z: the model-space vector that becomes up")->excludes(keep);
  app.add_option("--slicer", slicer, "builtin, or an installed one: prusa-slicer, cura-engine")
      ->check(CLI::IsMember({config::kBuiltinSlicer, config::kPrusaSlicer, config::kCuraEngine}));
  app.add_option("--slicer-profile", slicer_profile,
                 "that slicer's own profile: an exported .ini; for Cura, settings");
  if (!parse(app, args)) return 0;

  Settings s = settings_from(common, orient);
  if (as_delivered) s.options.orient.method = orient::Method::as_delivered;
  s.options.orient.all_criteria = false;  // nobody is told them
  if (!direction.empty()) {
    const auto d = numbers_from("--direction", direction, 3);
    s.options.direction = geom::Vec3(d[0], d[1], d[2]);
    if (s.options.direction->norm() < 1e-9)
      throw UsageError("--direction " + direction + ": it has no length");
    s.options.direction->normalize();
  }
  const bool x3g = is_x3g_name(out);
  if (x3g && s.profile.limits.firmware != motion::Firmware::s3g)
    throw UsageError(out + ": only a MakerBot reads .x3g, and the profile is not one's: give --profile");
  const std::string used = slicer.empty() ? s.daemon.slicer.name : slicer;
  s.options.slicer =
      daemon::foreign_slicer(s.daemon.slicer, used, own_profile(s.daemon, used, slicer_profile));
  const auto begin = std::chrono::steady_clock::now();
  const std::string gcode = x3g ? out + ".gcode" : out;
  const auto p = pipeline::prepare(model, gcode, s.options, false, console_context(common.threads));
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  end_progress();
  std::vector<std::string> left_out;
  if (x3g) left_out = convert_to_x3g(gcode, out, s.profile);

  const geom::Vec3 d = p.choice.candidates[p.choice.chosen].direction;
  if (common.json) {
    const nlohmann::ordered_json j = {{"file", out},
                                      {"direction", {d.x(), d.y(), d.z()}},
                                      {"layers", p.stats.layers},
                                      {"predicted_s", p.estimate.predicted_s},
                                      {"filament_mm", p.estimate.filament_mm},  // the start G-code's too
                                      {"extruded_mm3", p.stats.extruded_mm3},
                                      {"travel_mm", p.stats.travel_mm},
                                      {"retractions", p.stats.retractions},
                                      {"slicer", used},
                                      {"elapsed_s", elapsed}};
    std::cout << j.dump(2) << '\n';
    return 0;
  }
  for (const std::string& note : p.model.notes) std::fprintf(stderr, "%s: %s\n", model.c_str(), note.c_str());
  for (const std::string& note : left_out) std::fprintf(stderr, "%s: %s\n", out.c_str(), note.c_str());
  for (const std::string& message : p.slicer_messages) std::fprintf(stderr, "%s\n", message.c_str());
  for (const std::string& fix : p.model.repairs.sentences())
    std::fprintf(stderr, "%s: %s\n", model.c_str(), fix.c_str());
  std::printf(
      "%s: %zu layers, %s predicted, %.2f m of filament, %.1f m of travel, %zu retractions (%.2f s)\n",
      out.c_str(), p.stats.layers, duration_text(p.estimate.predicted_s).c_str(),
      p.estimate.filament_mm / 1000, p.stats.travel_mm / 1000, p.stats.retractions, elapsed);
  return 0;
}

}  // namespace voidpath::cli
