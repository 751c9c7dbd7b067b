#include "engine/mesh/holes.h"

#include "engine/mesh/edges.h"
#include "engine/mesh/triangulate.h"

#include <algorithm>
#include <unordered_map>

namespace voidpath::mesh {

namespace {

/// Area of the lids over area of the shell above which the shell is a sheet: closing it would invent a
/// part. A flat sheet has 1, a hemisphere without base 0.5, a box without one side 0.2.
constexpr double kMaxLidShare = 0.8;
/// Rings longer than this are closed from their centre: a quadratic search would take too long.
constexpr std::size_t kMaxRing = 5000;
/// Up to this many points the lid of least area is found; beyond, ears are clipped.
constexpr std::size_t kLeastAreaRing = 100;
/// No lid is smaller than the vector area of its ring; one within this share of it is flat.
constexpr double kFlatExcess = 1e-6;

using Ring = std::vector<std::uint32_t>;

using Side = std::pair<std::uint32_t, std::uint32_t>;

/// Cuts directed sides into rings that pass no vertex twice.
std::vector<Ring> rings_of(const std::vector<Side>& sides) {
  std::unordered_multimap<std::uint32_t, std::uint32_t> next(sides.begin(), sides.end());
  std::vector<Ring> rings;
  std::unordered_map<std::uint32_t, std::size_t> at;  // vertex to its place in the path
  Ring path;
  for (const Side& side : sides) {
    path.clear();
    at.clear();
    std::uint32_t v = side.first;
    for (;;) {
      const auto seen = at.find(v);
      if (seen != at.end()) {
        const std::size_t from = seen->second;
        if (path.size() - from >= 3) {
          rings.emplace_back(path.begin() + static_cast<std::ptrdiff_t>(from), path.end());
        }
        for (std::size_t i = from; i < path.size(); ++i) at.erase(path[i]);
        path.resize(from);
      }
      const auto way = next.find(v);
      if (way == next.end()) break;
      at[v] = path.size();
      path.push_back(v);
      v = way->second;
      next.erase(way);
    }
  }
  return rings;
}

std::vector<Vec3> points_of(const TriangleMesh& mesh, const Ring& ring) {
  std::vector<Vec3> points;
  points.reserve(ring.size());
  for (const std::uint32_t v : ring) points.push_back(mesh.vertices[v]);
  return points;
}

double twice_area(const std::vector<Vec3>& points, const std::vector<Triangle>& facets) {
  double sum = 0;
  for (const Triangle& t : facets) {
    sum += (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).norm();
  }
  return sum;
}

/// Ears clipped in its plane serve a flat ring best; for others a small lid is sought.
std::vector<Triangle> lid_for(const std::vector<Vec3>& points) {
  std::vector<Triangle> lid;
  const bool clean = triangulate(points, lid);
  const bool flat = clean && twice_area(points, lid) <= (1 + kFlatExcess) * ring_vector_area(points).norm();
  if (flat || points.size() > kLeastAreaRing) return lid;
  lid.clear();
  triangulate_least_area(points, lid);
  return lid;
}

void fill(TriangleMesh& mesh, const Ring& ring, HoleReport& report) {
  const std::vector<Vec3> points = points_of(mesh, ring);
  const std::size_t before = mesh.triangles.size();
  if (ring.size() > kMaxRing) {
    Vec3 centre = Vec3::Zero();
    for (const Vec3& p : points) centre += p;
    const auto c = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(centre / static_cast<double>(points.size()));
    for (std::size_t i = 0; i < ring.size(); ++i) {
      mesh.triangles.push_back({ring[i], ring[(i + 1) % ring.size()], c});
    }
  } else {
    const std::vector<Triangle> lid = lid_for(points);
    for (const Triangle& t : lid) mesh.triangles.push_back({ring[t[0]], ring[t[1]], ring[t[2]]});
  }
  ++report.holes_filled;
  report.triangles_added += mesh.triangles.size() - before;
}

}  // namespace

HoleReport fill_holes(TriangleMesh& mesh) {
  HoleReport report;
  const std::vector<Side> missing = EdgeTable(mesh).missing_sides(mesh);
  if (missing.empty()) return report;
  UnionFind shells(mesh.vertices.size());
  for (const Triangle& t : mesh.triangles) {
    shells.unite(t[0], t[1]);
    shells.unite(t[0], t[2]);
  }
  std::vector<double> shell_area(mesh.vertices.size(), 0), lid_area(mesh.vertices.size(), 0);
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[t[0]];
    shell_area[shells.find(t[0])] += (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm();
  }
  const std::vector<Ring> rings = rings_of(missing);
  for (const Ring& r : rings) lid_area[shells.find(r[0])] += ring_vector_area(points_of(mesh, r)).norm();
  for (const Ring& r : rings) {
    const std::uint32_t shell = shells.find(r[0]);
    if (lid_area[shell] <= kMaxLidShare * shell_area[shell]) fill(mesh, r, report);
  }
  return report;
}

}  // namespace voidpath::mesh
