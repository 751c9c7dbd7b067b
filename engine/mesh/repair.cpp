#include "engine/mesh/repair.h"

#include "engine/mesh/degenerate.h"
#include "engine/mesh/edges.h"
#include "engine/mesh/holes.h"
#include "engine/mesh/orientation.h"
#include "engine/mesh/seams.h"
#include "engine/mesh/weld.h"

#include <algorithm>
#include <memory>

namespace voidpath::mesh {

namespace {

/// Closing one gap may lay bare another; rubbish would go on for ever.
constexpr int kMaxRounds = 4;
/// Share of facets that have a twin looking the other way at which the file is taken for one exported with
/// both sides of every face. Below it such twins are where two bodies touch, which is sound.
constexpr double kTwoSided = 0.9;

void keep(TriangleMesh& mesh, const std::vector<bool>& gone) {
  std::size_t n = 0;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    if (!gone[f]) mesh.triangles[n++] = mesh.triangles[f];
  }
  mesh.triangles.resize(n);
}

/// Facets with a corner used twice go. Those with corners on a line close the mesh like any other where
/// each side has its partner, and stay; they go where they do not.
std::size_t drop_degenerate(TriangleMesh& mesh) {
  std::vector<bool> gone(mesh.triangles.size(), false);
  std::size_t count = 0;
  bool flat = false;
  for (std::size_t f = 0; f < gone.size(); ++f) {
    gone[f] = has_repeated_corner(mesh.triangles[f]);
    count += gone[f] ? 1u : 0u;
    flat = flat || (!gone[f] && has_no_area(mesh, mesh.triangles[f]));
  }
  if (flat) {
    for (const std::uint32_t slot : EdgeTable(mesh).open_slots()) {
      const std::uint32_t f = facet_of(slot);
      if (gone[f] || !has_no_area(mesh, mesh.triangles[f])) continue;
      gone[f] = true;
      ++count;
    }
  }
  if (count > 0) keep(mesh, gone);
  return count;
}

/// Takes back removals that would leave an edge unbalanced which was balanced before: there the duplicates
/// stand for bodies that touch.
void spare_balanced(const TriangleMesh& mesh, const EdgeTable& edges, std::vector<bool>& gone) {
  for (bool spared = true; spared;) {
    spared = false;
    edges.for_each([&](std::uint32_t low, std::uint32_t, std::span<const EdgeUse> uses) {
      int before = 0, after = 0;
      for (const EdgeUse& u : uses) {
        const int way = edge_begin(mesh, u.slot) == low ? 1 : -1;
        before += way;
        if (!gone[facet_of(u.slot)]) after += way;
      }
      if (before != 0 || after == 0) return;
      for (const EdgeUse& u : uses) {
        spared = spared || gone[facet_of(u.slot)];
        gone[facet_of(u.slot)] = false;
      }
    });
  }
}

std::size_t drop_duplicates(TriangleMesh& mesh) {
  const EdgeTable edges(mesh);
  const Twins twins = find_twins(mesh, edges);
  const auto reversed = std::count(twins.reversed.begin(), twins.reversed.end(), true);
  const bool two_sided =
      2 * static_cast<double>(reversed) >= kTwoSided * static_cast<double>(mesh.triangles.size());
  std::vector<bool> gone(mesh.triangles.size(), false);
  bool any = false;
  for (std::uint32_t f = 0; f < gone.size(); ++f) {
    gone[f] = twins.first[f] != f && (two_sided || !twins.reversed[f]);
    any = any || gone[f];
  }
  if (any && !two_sided) spare_balanced(mesh, edges, gone);
  const auto count = static_cast<std::size_t>(std::count(gone.begin(), gone.end(), true));
  if (count > 0) keep(mesh, gone);
  return count;
}

bool has_open_sides(const TriangleMesh& mesh) { return !EdgeTable(mesh).open_slots().empty(); }

void close_gaps(TriangleMesh& mesh, RepairReport& r) {
  if (!has_open_sides(mesh)) return;
  r.vertices_merged += merge_open_sides(mesh).vertices_merged;
  r.degenerate_removed += drop_degenerate(mesh);
  r.triangles_added += cut_at_open_vertices(mesh).triangles_added;
  r.vertices_merged += merge_open_sides(mesh).vertices_merged;
  r.degenerate_removed += drop_degenerate(mesh);
}

void turn(TriangleMesh& mesh, const Orientation& o, RepairReport& r) {
  r.faces_flipped += o.faces_flipped;
  r.shells_inverted += o.shells_inverted;
  if (o.faces_flipped + o.shells_inverted > 0) apply(o, mesh);
}

/// Every edge is walked as often one way as the other and no facet is there twice: what remains to be asked
/// is which way the shells look.
bool is_closed(const TriangleMesh& mesh, const EdgeTable& edges) {
  if (std::any_of(mesh.triangles.begin(), mesh.triangles.end(), has_repeated_corner)) return false;
  if (!edges.missing_sides(mesh).empty()) return false;
  const Twins twins = find_twins(mesh, edges);
  for (std::uint32_t f = 0; f < twins.first.size(); ++f) {
    if (twins.first[f] != f) return false;
  }
  return true;
}

void close(TriangleMesh& mesh, RepairReport& r) {
  r.degenerate_removed += drop_degenerate(mesh);
  r.duplicates_removed += drop_duplicates(mesh);
  close_gaps(mesh, r);
  if (EdgeTable(mesh).missing_sides(mesh).empty()) return;
  turn(mesh, agree_in_patches(mesh, EdgeTable(mesh)), r);
  const HoleReport holes = fill_holes(mesh);
  r.holes_filled += holes.holes_filled;
  r.triangles_added += holes.triangles_added;
}

/// Whether anything changed.
bool repair_once(TriangleMesh& mesh, RepairReport& total) {
  RepairReport r;
  auto edges = std::make_unique<EdgeTable>(mesh);
  if (!is_closed(mesh, *edges)) {
    edges.reset();  // not two at a time: it is as large as the mesh
    close(mesh, r);
    edges = std::make_unique<EdgeTable>(mesh);
  }
  turn(mesh, solve_orientation(mesh, *edges), r);
  total.open_edges_left = edges->open_slots().size();  // turning facets opens none
  if (r.changed()) drop_unused_vertices(mesh);
  total.vertices_merged += r.vertices_merged;
  total.degenerate_removed += r.degenerate_removed;
  total.duplicates_removed += r.duplicates_removed;
  total.faces_flipped += r.faces_flipped;
  total.shells_inverted += r.shells_inverted;
  total.holes_filled += r.holes_filled;
  total.triangles_added += r.triangles_added;
  return r.changed();
}

std::string counted(std::size_t n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

}  // namespace

RepairReport repair(TriangleMesh& mesh) {
  RepairReport report;
  for (int round = 0; round < kMaxRounds && repair_once(mesh, report); ++round) {
  }
  return report;
}

std::vector<std::string> RepairReport::sentences() const {
  std::vector<std::string> out;
  const auto say = [&out](std::size_t n, const char* one, const char* many, const char* done) {
    if (n > 0) out.push_back(counted(n, one, many) + " " + done);
  };
  say(vertices_merged, "vertex", "vertices", "merged with a near one");
  say(degenerate_removed, "facet", "facets", "without area removed");
  say(duplicates_removed, "duplicate facet", "duplicate facets", "removed");
  say(faces_flipped, "facet", "facets", "turned to agree with the neighbours");
  say(shells_inverted, "shell", "shells", "turned outside out");
  say(holes_filled, "hole", "holes", "filled");
  say(triangles_added, "triangle", "triangles", "added");
  say(open_edges_left, "open edge", "open edges", "left");
  return out;
}

}  // namespace voidpath::mesh
