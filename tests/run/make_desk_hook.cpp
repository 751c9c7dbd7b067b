// Makes tests/assets/desk_hook.stl: a hook for headphones that clamps under a desk top, in the pose it is
// used in. Upright it is tall and its arms hang in the air; on its side it needs no support.

#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "engine/geom/polygon_ops.h"
#include "engine/mesh/triangulate.h"
#include "engine/mesh/write.h"

namespace {

using namespace voidpath;
using geom::from_mm;
using geom::Point;
using geom::Regions;

struct Mm {
  double x, y;
};

/// A thick line with round ends and corners.
Regions stroke(const std::vector<Mm>& line, double width) {
  geom::Rings rings;
  const double r = width / 2;
  for (std::size_t i = 0; i < line.size(); ++i) {
    rings.push_back(geom::make_circle({from_mm(line[i].x), from_mm(line[i].y)}, from_mm(r), 48));
    if (i == 0) continue;
    const Mm a = line[i - 1];
    const Mm b = line[i];
    const double l = std::hypot(b.x - a.x, b.y - a.y);
    const double nx = -(b.y - a.y) / l * r;
    const double ny = (b.x - a.x) / l * r;
    rings.push_back({{from_mm(a.x - nx), from_mm(a.y - ny)},
                     {from_mm(b.x - nx), from_mm(b.y - ny)},
                     {from_mm(b.x + nx), from_mm(b.y + ny)},
                     {from_mm(a.x + nx), from_mm(a.y + ny)}});
  }
  return geom::unite(rings);
}

std::vector<Mm> arc(double cx, double cy, double r, double from_deg, double to_deg) {
  std::vector<Mm> out;
  constexpr int kSteps = 24;
  for (int i = 0; i <= kSteps; ++i) {
    const double a = (from_deg + (to_deg - from_deg) * i / kSteps) * std::numbers::pi / 180;
    out.push_back({cx + r * std::cos(a), cy + r * std::sin(a)});
  }
  return out;
}

/// The hook seen from the side: x towards the user, y up.
Regions profile() {
  Regions all = stroke({{0, 0}, {0, 62}}, 8);                                // spine
  all = geom::unite(all, stroke({{0, 62}, {38, 62}}, 8));                    // over the desk top
  all = geom::unite(all, stroke({{0, 30}, {34, 30}}, 7));                    // below it
  all = geom::unite(all, stroke({{34, 30}, {36, 33}}, 6));                   // catch
  all = geom::unite(all, stroke({{0, 12}, {20, 30}}, 6));                    // brace
  auto hook = arc(26, 0, 26, 180, 345);
  all = geom::unite(all, stroke(hook, 9));                                   // where the headphones hang
  return geom::subtract(all, stroke({{0, 42}, {0, 53}}, 3.2));               // slot for a cable tie
}

void add_cap(mesh::TriangleMesh& out, const geom::Ring& ring, double z, bool top) {
  std::vector<mesh::Vec3> points;
  for (const Point& p : ring) points.emplace_back(geom::to_mm(p.x), geom::to_mm(p.y), 0);
  std::vector<mesh::Triangle> triangles;
  mesh::triangulate(points, triangles);
  const auto base = static_cast<std::uint32_t>(out.vertices.size());
  for (const auto& p : points) out.vertices.emplace_back(p.x(), p.y(), z);
  for (auto t : triangles) {
    if (!top) std::swap(t[1], t[2]);
    out.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  }
}

void add_wall(mesh::TriangleMesh& out, Point a, Point b, double height) {
  const auto base = static_cast<std::uint32_t>(out.vertices.size());
  for (const Point p : {a, b})
    for (const double z : {0.0, height}) out.vertices.emplace_back(geom::to_mm(p.x), geom::to_mm(p.y), z);
  out.triangles.push_back({base, base + 2, base + 3});
  out.triangles.push_back({base, base + 3, base + 1});
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: make-desk-hook FILE.stl\n"), 2;
  constexpr double kWidth_mm = 22;
  const Regions side = profile();
  // Cut through the slot and through the opening below the brace, so that no piece has a hole and each cap
  // is a plain ring.
  constexpr geom::Coord kFar = 200'000'000;
  const std::vector<geom::Coord> cuts = {-kFar, 0, from_mm(7), kFar};

  mesh::TriangleMesh mesh;
  for (std::size_t strip = 0; strip + 1 < cuts.size(); ++strip)
    for (const geom::Region& piece :
         geom::intersect(side, {{geom::make_rectangle({cuts[strip], -kFar}, {cuts[strip + 1], kFar}), {}}})) {
      if (!piece.holes.empty()) return std::fprintf(stderr, "a piece has a hole\n"), 1;
      add_cap(mesh, piece.outer, 0, false);
      add_cap(mesh, piece.outer, kWidth_mm, true);
      for (std::size_t i = 0; i < piece.outer.size(); ++i) {
        const Point a = piece.outer[i];
        const Point b = piece.outer[(i + 1) % piece.outer.size()];
        const bool on_cut = a.x == b.x && (a.x == cuts[strip] || a.x == cuts[strip + 1]);
        if (!on_cut) add_wall(mesh, a, b, kWidth_mm);
      }
    }
  // From the side view to the pose of use: y becomes up.
  for (auto& v : mesh.vertices) v = mesh::Vec3(v.x(), -v.z(), v.y());
  mesh::write_model(mesh, argv[1]);
  std::printf("%s: %zu triangles, %.0f mm3\n", argv[1], mesh.triangles.size(), mesh::volume(mesh));
  return 0;
}
