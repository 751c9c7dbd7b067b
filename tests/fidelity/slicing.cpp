#include "tests/fidelity/slicing.h"

#include "config/config.h"
#include "engine/mesh/import.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace voidpath::fidelity {

namespace {

/// A branch may widen by this much a mm upwards, beside its lean.
constexpr double kBranchWidening = 0.3;
/// No place that is to be held is further from a tip than this share of what tips are apart.
constexpr double kTipShare = 0.65;
/// Distances between pixels are kept in floats, mm.
constexpr double kRounding = 1e-5;
/// Of the extruded volume, as a share.
constexpr double kVolumeError = 0.02;

double degrees(double slope) { return std::atan(slope) * 180 / M_PI; }
double slope(double angle_deg) { return std::tan(angle_deg * M_PI / 180); }

/// Of the raft and the air above it.
double ground_of(const toolpath::SliceSettings& s) {
  if (s.raft_layers <= 0) return 0;
  return s.first_layer_height_mm + (s.raft_layers - 1) * s.layer_height_mm + s.raft_gap_mm;
}

Rules rules_for(const toolpath::SliceSettings& s) {
  Rules r;
  r.line_width = s.line_width_mm;
  r.infill_density = s.infill_density;
  r.support_density = s.support_density;
  r.support_angle_deg = s.support_angle_deg;
  // Beside the part support keeps a gap; tips that bear no roof are apart.
  const bool tips = s.support_style == toolpath::SupportStyle::tree && s.support_interface_layers == 0;
  r.support_reach = std::max(s.support_xy_gap_mm, tips ? kTipShare * s.tree_tip_distance_mm : 0.0);
  r.support_z_gap = s.support_z_gap_mm;
  r.branch_angle_deg = s.support_style == toolpath::SupportStyle::tree
                           ? degrees(slope(s.tree_branch_angle_deg) + kBranchWidening)
                           : s.support_angle_deg;
  r.from_plate = s.support == toolpath::SupportMode::plate;
  r.ground = ground_of(s);
  r.outer_growth = s.xy_compensation_mm;
  r.hole_growth = s.hole_compensation_mm;
  r.foot = s.raft_layers > 0 ? 0 : s.elephant_foot_mm;
  r.vase = s.spiral_vase;
  r.floor_layers = static_cast<std::size_t>(std::max(s.bottom_layers, 1));
  return r;
}

}  // namespace

pipeline::PrepareOptions options_for(const Set& set) {
  const config::Profile profile = config::load_profile("generic-marlin", set);
  pipeline::PrepareOptions options;
  options.print = profile.print;
  options.limits = profile.limits;
  options.print.machine.bed_mm = {1500, 1500};
  options.print.machine.height_mm = 1500;
  options.print.machine.start_gcode.clear();
  options.print.machine.end_gcode.clear();
  return options;
}

Sliced sliced(const mesh::TriangleMesh& mesh, const pipeline::PrepareOptions& options,
              const run::Context& ctx) {
  const geom::Vec3 up = geom::Vec3::UnitZ();
  const auto& p = options.print;
  Sliced out;
  std::ostringstream text;
  pipeline::slice_part(mesh, up, options, text, ctx);
  out.gcode = text.str();
  out.rules = rules_for(p.slice);
  out.placed = mesh::turned(mesh, up);
  for (auto& v : out.placed.vertices)
    v += geom::Vec3(0.5 * p.machine.bed_mm[0], 0.5 * p.machine.bed_mm[1], out.rules.ground);
  out.filament_diameter = p.filament.diameter_mm;
  out.flow = p.filament.flow;
  return out;
}

mesh::TriangleMesh imported(const test::RealModel& model) {
  mesh::ImportOptions options;
  options.scale = model.scale;
  return mesh::import_model(model.file, options).mesh;
}

Print read(const Sliced& part) {
  std::istringstream in(part.gcode);
  return read_print(in, part.filament_diameter, part.flow);
}

Findings checked(const Sliced& part) {
  const Print print = read(part);
  Findings found = check(part.placed, print, part.rules);
  found.complaints = print.complaints;
  return found;
}

double outside_limit(const Findings& f) { return 0.05 + 1.5 * f.pixel; }
double hole_limit(const Findings& f) { return 0.15 + f.pixel; }

Bounds bounds_for(const Rules& rules) {
  Bounds b;
  b.support_span = rules.line_width / rules.support_density;
  return b;
}

std::vector<Excess> excesses(const Findings& f, const Bounds& bounds) {
  std::vector<Excess> out;
  for (const std::string& complaint : f.complaints) out.push_back({complaint, 0, 0, ""});
  const auto within = [&](const char* name, const Worst& found, double limit) {
    if (!(found.value <= limit + kRounding)) out.push_back({name, found.value, limit, found.where});
  };
  within("outside", f.outside, outside_limit(f));
  within("uncovered", f.uncovered, 1);
  within("top hole", f.top_hole, hole_limit(f));
  within("bottom hole", f.bottom_hole, std::max(hole_limit(f), bounds.bottom_hole));
  if (bounds.held) {
    within("loose", f.loose, kTip);
    within("unannounced", f.unannounced, kTip);
  }
  within("support loose", f.support_loose, kTip);
  within("support span", f.support_span, bounds.support_span);
  within("wall gap", f.wall_gap, outside_limit(f));
  within("brim inside", f.brim_inside, outside_limit(f));
  within("volume", {std::abs(f.volume_ratio - 1), ""}, kVolumeError);
  return out;
}

std::vector<std::string> beyond_bounds(const Findings& f, const Bounds& bounds) {
  std::vector<std::string> out;
  for (Excess& e : excesses(f, bounds)) out.push_back(std::move(e.name));
  return out;
}

std::string told(const std::string& name, const Findings& f) {
  std::ostringstream s;
  const auto worst = [&](const char* what, const Worst& w) {
    if (w.value > 0) s << "  " << what << " " << w.value << " " << w.where << "\n";
  };
  s << name << ": " << f.layers << " layers, pixel " << f.pixel << " mm\n";
  worst("outside", f.outside);
  worst("uncovered/allowed", f.uncovered);
  worst("inset", f.inset);
  worst("top hole", f.top_hole);
  worst("bottom hole", f.bottom_hole);
  worst("loose", f.loose);
  worst("unannounced", f.unannounced);
  worst("support loose", f.support_loose);
  worst("support span", f.support_span);
  worst("wall gap", f.wall_gap);
  worst("brim inside", f.brim_inside);
  worst("brim away", f.brim_away);
  s << "  loose " << f.loose_mm << ", unannounced " << f.unannounced_mm << " of " << f.length_mm
    << " mm; support " << f.support_mm << " mm; volume " << f.volume_ratio << "\n";
  return s.str();
}

}  // namespace voidpath::fidelity
