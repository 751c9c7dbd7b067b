#include <cstdio>
#include <iostream>

#include <nlohmann/json.hpp>

#include "daemon/cli/flags.h"
#include "daemon/cli/offline.h"

namespace voidpath::cli {

namespace {

nlohmann::ordered_json report_json(const std::string& file, const mesh::Import& m) {
  const auto& r = m.delivered;
  const auto size = mesh::bounds(m.mesh).size();
  return {{"file", file},
          {"format", m.format},
          {"triangles", r.triangles},
          {"size_mm", {size.x(), size.y(), size.z()}},
          {"volume_mm3", mesh::volume(m.mesh)},
          {"shells", r.shells},
          {"watertight", r.watertight()},
          {"open_edges", r.open_edges},
          {"non_manifold_edges", r.non_manifold_edges},
          {"misoriented_edges", r.misoriented_edges},
          {"flipped_faces", r.flipped_faces},
          {"degenerate_faces", r.degenerate_faces},
          {"duplicate_faces", r.duplicate_faces},
          {"repaired", m.repairs.changed()},
          {"repairs", m.repairs.sentences()},
          {"open_edges_left", m.repairs.open_edges_left},
          {"notes", m.notes}};
}

}  // namespace

int check_command(const std::vector<std::string>& args) {
  CLI::App app("Reports on a mesh: can it be printed, and what had to be mended", "check");
  CommonFlags common;
  std::string file;
  app.add_option("model", file, "STL, OBJ or 3MF")->required();
  add_common(app, common);
  if (!parse(app, args)) return 0;

  const Settings s = settings_from(common, {});
  const mesh::Import m = mesh::import_model(file, s.options.import, console_context(common.threads));
  end_progress();
  if (common.json) {
    std::cout << report_json(file, m).dump(2) << '\n';
    return 0;
  }
  const auto& r = m.delivered;
  const auto size = mesh::bounds(m.mesh).size();
  std::printf("%s: %s, %zu triangles, %.2f x %.2f x %.2f mm, %.0f mm3, %zu shell%s\n", file.c_str(), m.format.c_str(),
              r.triangles, size.x(), size.y(), size.z(), mesh::volume(m.mesh), r.shells, r.shells == 1 ? "" : "s");
  std::printf("  open edges %zu, non-manifold edges %zu, misoriented edges %zu, flipped faces %zu\n", r.open_edges,
              r.non_manifold_edges, r.misoriented_edges, r.flipped_faces);
  for (const std::string& fix : m.repairs.sentences()) std::printf("  %s\n", fix.c_str());
  for (const std::string& note : m.notes) std::printf("  %s\n", note.c_str());
  std::puts(m.repairs.open_edges_left == 0 ? "  it can be printed" :
                                             "  it can be printed; what stays open is closed layer by layer");
  return 0;
}

}  // namespace voidpath::cli
