#include "engine/mesh/seams.h"

#include "engine/mesh/edges.h"
#include "engine/mesh/triangulate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace voidpath::mesh {

namespace {

/// Gaps as fractions of the diagonal, tried one after the other so that the nearest sides find each other
/// first: float rounding, its accumulation in transforms, sloppy export.
constexpr double kGapFractions[] = {1e-6, 1e-5, 1e-4};
/// mm. No gap wider than a quarter of a usual nozzle line is closed by moving vertices.
constexpr double kMaxGap = 0.1;
/// Neighbours looked at around one place; more crowd together only in heaps of rubbish.
constexpr std::size_t kMaxCandidates = 256;

double gap_of(const TriangleMesh& mesh, double fraction) {
  return std::min(kMaxGap, fraction * bounds(mesh).size().norm());
}

/// Points in cubes of a given size, found by the cubes around a place.
class PointGrid {
 public:
  PointGrid(double cell, const Vec3& origin) : cell_(cell), origin_(origin) {}

  void add(const Vec3& p, std::uint32_t what) { cells_.push_back({key(index(p)), what}); }
  void done() { std::sort(cells_.begin(), cells_.end()); }

  /// Calls visit(what) for those in the 27 cubes around p, kMaxCandidates at most.
  template <class Visit>
  void around(const Vec3& p, Visit&& visit) const {
    const auto c = index(p);
    std::size_t looked = 0;
    for (std::int64_t x = -1; x <= 1; ++x) {
      for (std::int64_t y = -1; y <= 1; ++y) {
        for (std::int64_t z = -1; z <= 1; ++z) {
          const std::uint64_t k = key({c[0] + x, c[1] + y, c[2] + z});
          auto at = std::lower_bound(cells_.begin(), cells_.end(), std::pair(k, std::uint32_t{0}));
          for (; at != cells_.end() && at->first == k; ++at) {
            if (++looked > kMaxCandidates) return;
            visit(at->second);
          }
        }
      }
    }
  }

 private:
  std::array<std::int64_t, 3> index(const Vec3& p) const {
    const Vec3 q = (p - origin_) / cell_;
    return {std::llround(std::floor(q.x())), std::llround(std::floor(q.y())),
            std::llround(std::floor(q.z()))};
  }
  /// Different cubes may share a key far apart; whoever asks checks distances anyway.
  static std::uint64_t key(const std::array<std::int64_t, 3>& c) {
    const auto u = [](std::int64_t v) { return static_cast<std::uint64_t>(v) & 0x1fffff; };
    return u(c[0]) << 42 | u(c[1]) << 21 | u(c[2]);
  }

  double cell_;
  Vec3 origin_;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> cells_;
};

struct Side {
  std::uint32_t slot, a, b;
};

struct Match {
  double gap;
  std::uint32_t i, j;  ///< sides
  bool opposed;        ///< they run against each other, as sides of agreeing facets do
};

std::vector<Side> open_sides(const TriangleMesh& mesh) {
  std::vector<Side> sides;
  for (const std::uint32_t slot : EdgeTable(mesh).open_slots()) {
    sides.push_back({slot, edge_begin(mesh, slot), edge_end(mesh, slot)});
  }
  return sides;
}

std::vector<Match> near_sides(const TriangleMesh& mesh, const std::vector<Side>& sides, double gap) {
  const auto middle = [&](const Side& s) { return Vec3(0.5 * (mesh.vertices[s.a] + mesh.vertices[s.b])); };
  PointGrid grid(gap, bounds(mesh).min);
  for (std::uint32_t i = 0; i < sides.size(); ++i) grid.add(middle(sides[i]), i);
  grid.done();
  std::vector<Match> matches;
  for (std::uint32_t i = 0; i < sides.size(); ++i) {
    const Vec3 &a = mesh.vertices[sides[i].a], &b = mesh.vertices[sides[i].b];
    if ((b - a).norm() <= 2 * gap) continue;
    grid.around(middle(sides[i]), [&](std::uint32_t j) {
      if (j <= i || facet_of(sides[j].slot) == facet_of(sides[i].slot)) return;
      const Vec3 &c = mesh.vertices[sides[j].a], &d = mesh.vertices[sides[j].b];
      const double opposed = std::max((a - d).norm(), (b - c).norm());
      const double along = std::max((a - c).norm(), (b - d).norm());
      if (std::min(opposed, along) > gap) return;
      matches.push_back({std::min(opposed, along), i, j, opposed <= along});
    });
  }
  std::sort(matches.begin(), matches.end(), [](const Match& p, const Match& q) {
    return std::tie(p.gap, p.i, p.j) < std::tie(q.gap, q.i, q.j);
  });
  return matches;
}

std::size_t merge_within(TriangleMesh& mesh, double gap) {
  const std::vector<Side> sides = open_sides(mesh);
  if (sides.size() < 2) return 0;
  UnionFind same(mesh.vertices.size());
  std::vector<bool> taken(sides.size(), false);
  std::size_t merged = 0;
  for (const Match& m : near_sides(mesh, sides, gap)) {
    if (taken[m.i] || taken[m.j]) continue;
    taken[m.i] = taken[m.j] = true;
    const Side &s = sides[m.i], &t = sides[m.j];
    merged += same.unite(s.a, m.opposed ? t.b : t.a) ? 1u : 0u;
    merged += same.unite(s.b, m.opposed ? t.a : t.b) ? 1u : 0u;
  }
  if (merged == 0) return 0;
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& v : t) v = same.find(v);
  }
  return merged;
}

/// Vertices on the inside of the segment, in order along it.
std::vector<std::uint32_t> on_segment(const TriangleMesh& mesh, const PointGrid& grid, const Side& side,
                                      double cell, double gap) {
  const Vec3 a = mesh.vertices[side.a], along = mesh.vertices[side.b] - a;
  const double length = along.norm();
  std::vector<std::pair<double, std::uint32_t>> found;
  const std::uint32_t apex = opposite(mesh, side.slot);
  const auto steps = static_cast<std::size_t>(length / cell) + 1;
  for (std::size_t i = 0; i <= steps; ++i) {
    grid.around(a + along * (static_cast<double>(i) / static_cast<double>(steps)), [&](std::uint32_t v) {
      if (v == side.a || v == side.b || v == apex) return;
      const double t = (mesh.vertices[v] - a).dot(along) / length;
      if (t <= gap || t >= length - gap) return;
      if ((mesh.vertices[v] - a - along * (t / length)).norm() <= gap) found.emplace_back(t, v);
    });
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::vector<std::uint32_t> out;
  for (const auto& f : found) out.push_back(f.second);
  return out;
}

}  // namespace

SeamReport merge_open_sides(TriangleMesh& mesh) {
  SeamReport report;
  for (const double fraction : kGapFractions) {
    const double gap = gap_of(mesh, fraction);
    if (gap > 0) report.vertices_merged += merge_within(mesh, gap);
  }
  return report;
}

SeamReport cut_at_open_vertices(TriangleMesh& mesh) {
  SeamReport report;
  const std::vector<Side> sides = open_sides(mesh);
  const double gap = gap_of(mesh, kGapFractions[1]);
  if (sides.size() < 3 || gap <= 0) return report;
  // Cubes as large as the mean side: then the sides cross few cubes altogether and few vertices share one.
  double length = 0;
  for (const Side& s : sides) length += (mesh.vertices[s.b] - mesh.vertices[s.a]).norm();
  const double cell = std::max(gap, length / static_cast<double>(sides.size()));
  PointGrid grid(cell, bounds(mesh).min);
  std::vector<std::uint32_t> vertices;
  for (const Side& s : sides) vertices.insert(vertices.end(), {s.a, s.b});
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  for (const std::uint32_t v : vertices) grid.add(mesh.vertices[v], v);
  grid.done();

  std::map<std::uint32_t, std::array<std::vector<std::uint32_t>, 3>> cuts;  // by facet
  for (const Side& s : sides) {
    std::vector<std::uint32_t> inner = on_segment(mesh, grid, s, cell, gap);
    if (!inner.empty()) cuts[facet_of(s.slot)][s.slot % 3] = std::move(inner);
  }
  std::vector<std::uint32_t> ring;
  std::vector<Vec3> points;
  std::vector<Triangle> pieces;
  for (const auto& [facet, inner] : cuts) {
    ring.clear();
    points.clear();
    pieces.clear();
    for (std::size_t k = 0; k < 3; ++k) {
      ring.push_back(mesh.triangles[facet][k]);
      ring.insert(ring.end(), inner[k].begin(), inner[k].end());
    }
    for (const std::uint32_t v : ring) points.push_back(mesh.vertices[v]);
    triangulate(points, pieces);
    const auto named = [&](const Triangle& t) { return Triangle{ring[t[0]], ring[t[1]], ring[t[2]]}; };
    mesh.triangles[facet] = named(pieces.front());
    for (std::size_t i = 1; i < pieces.size(); ++i) mesh.triangles.push_back(named(pieces[i]));
    report.triangles_added += pieces.size() - 1;
  }
  return report;
}

}  // namespace voidpath::mesh
