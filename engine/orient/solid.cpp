#include "engine/orient/solid.h"

#include "engine/orient/fill.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

namespace voidpath::orient {

namespace {

/// Bits of a coordinate spread out so that two others' fit between. 10 bits.
std::uint32_t spread_bits(std::uint32_t x) {
  x = (x | x << 16U) & 0x030000FFU;
  x = (x | x << 8U) & 0x0300F00FU;
  x = (x | x << 4U) & 0x030C30C3U;
  return (x | x << 2U) & 0x09249249U;
}

/// Orders points along a curve through the box around them that stays near where it is (Morton 1966).
std::vector<Index> order_in_space(const std::vector<Vec3>& points) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double size = std::max((high - low).maxCoeff(), std::numeric_limits<double>::min());
  std::vector<std::uint64_t> keys(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Matrix<std::uint32_t, 3, 1> cell = ((points[i] - low) * (1023 / size)).cast<std::uint32_t>();
    const std::uint32_t code =
        spread_bits(cell.x()) | spread_bits(cell.y()) << 1U | spread_bits(cell.z()) << 2U;
    keys[i] = std::uint64_t{code} << 32U | i;
  }
  std::sort(keys.begin(), keys.end());
  std::vector<Index> out(points.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<Index>(keys[i]);
  return out;
}

/// Puts together in memory what lies together in space: looking at the part from any side then finds most of
/// what it asks for at hand.
void lay_out(Solid& s) {
  const std::vector<Index> vertices = order_in_space(s.vertices);
  std::vector<Index> now_at(vertices.size());
  std::vector<Vec3> moved(vertices.size());
  for (Index i = 0; i < vertices.size(); ++i) {
    now_at[vertices[i]] = i;
    moved[i] = s.vertices[vertices[i]];
  }
  s.vertices = std::move(moved);
  std::vector<Vec3> middles;
  middles.reserve(s.triangles.size());
  for (mesh::Triangle& t : s.triangles) {
    t = {now_at[t[0]], now_at[t[1]], now_at[t[2]]};
    middles.push_back((s.vertices[t[0]] + s.vertices[t[1]] + s.vertices[t[2]]) / 3);
  }
  std::vector<mesh::Triangle> facets;
  facets.reserve(s.triangles.size());
  for (const Index t : order_in_space(middles)) facets.push_back(s.triangles[t]);
  s.triangles = std::move(facets);
}

/// Corner k of facet t and the edge that leaves it.
using HalfEdge = std::uint64_t;
HalfEdge half_edge(std::size_t t, std::size_t k) { return t * 3 + k; }

struct EdgeUse {
  Index high;   ///< the larger vertex of the edge
  bool rising;  ///< runs from the smaller vertex to the larger
  HalfEdge half;
};

/// Joins the facets round one edge, each with its partner across the material between them.
void join_fan(const Solid& s, std::vector<EdgeUse>& uses, std::vector<mesh::Triangle>& beside) {
  auto set = [&](const EdgeUse& a, const EdgeUse& b) {
    beside[a.half / 3][a.half % 3] = static_cast<Index>(b.half / 3);
    beside[b.half / 3][b.half % 3] = static_cast<Index>(a.half / 3);
  };
  if (uses.size() == 2) {
    if (uses[0].rising != uses[1].rising) set(uses[0], uses[1]);
    return;
  }
  if (uses.size() < 2) return;
  const auto& first = s.triangles[uses[0].half / 3];
  const std::size_t k0 = uses[0].half % 3;
  const Index from = uses[0].rising ? first[k0] : first[(k0 + 1) % 3];
  const Vec3 origin = s.vertices[from];
  const Vec3 axis = (s.vertices[uses[0].high] - origin).normalized();
  const Vec3 e1 = axis.unitOrthogonal();
  const Vec3 e2 = axis.cross(e1);
  struct Spoke {
    double angle;
    EdgeUse use;
  };
  std::vector<Spoke> spokes;
  for (const EdgeUse& u : uses) {
    const Vec3 r = s.vertices[s.triangles[u.half / 3][(u.half % 3 + 2) % 3]] - origin;
    spokes.push_back({std::atan2(r.dot(e2), r.dot(e1)), u});
  }
  std::stable_sort(spokes.begin(), spokes.end(),
                   [](const Spoke& a, const Spoke& b) { return a.angle < b.angle; });
  // A facet whose edge rises along the axis looks towards growing angles, so material lies from each falling
  // spoke onward to the next rising one. Matching as brackets keeps overlapping bodies apart.
  std::vector<EdgeUse> open;
  std::vector<bool> taken(spokes.size(), false);
  for (std::size_t turn = 0; turn < 2 * spokes.size(); ++turn) {
    const std::size_t i = turn % spokes.size();
    if (taken[i]) continue;
    if (!spokes[i].use.rising) {
      if (turn < spokes.size()) open.push_back(spokes[i].use);
    } else if (!open.empty()) {
      set(open.back(), spokes[i].use);
      open.pop_back();
      taken[i] = true;
    }
  }
}

/// Facets across every edge, in linear time: half-edges are gathered at their smaller vertex.
void find_neighbours(Solid& s) {
  const std::size_t n = s.triangles.size();
  s.beside.assign(n, {kNone, kNone, kNone});
  std::vector<Index> start(s.vertices.size() + 1, 0);
  auto ends = [&](std::size_t t, std::size_t k) {
    return std::pair(s.triangles[t][k], s.triangles[t][(k + 1) % 3]);
  };
  for (std::size_t t = 0; t < n; ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = ends(t, k);
      ++start[std::min(a, b) + 1];
    }
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<EdgeUse> uses(3 * n);
  std::vector<Index> fill(start.begin(), start.end() - 1);
  for (std::size_t t = 0; t < n; ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = ends(t, k);
      uses[fill[std::min(a, b)]++] = {std::max(a, b), a < b, half_edge(t, k)};
    }
  std::vector<EdgeUse> fan;
  for (std::size_t v = 0; v + 1 < start.size(); ++v) {
    const auto begin = uses.begin() + start[v];
    const auto end = uses.begin() + start[v + 1];
    std::sort(begin, end, [](const EdgeUse& a, const EdgeUse& b) {
      return a.high != b.high ? a.high < b.high : a.half < b.half;
    });
    for (auto it = begin; it != end;) {
      auto stop = it;
      fan.clear();
      while (stop != end && stop->high == it->high) fan.push_back(*stop++);
      join_fan(s, fan, s.beside);
      it = stop;
    }
  }
}

void find_shells(Solid& s) {
  s.shell_of.assign(s.triangles.size(), kNone);
  std::vector<Index> todo;
  Index shells = 0;
  for (Index seed = 0; seed < s.triangles.size(); ++seed) {
    if (s.shell_of[seed] != kNone) continue;
    s.shell_of[seed] = shells;
    todo.push_back(seed);
    while (!todo.empty()) {
      const Index t = todo.back();
      todo.pop_back();
      for (const Index next : s.beside[t])
        if (next != kNone && s.shell_of[next] == kNone) {
          s.shell_of[next] = shells;
          todo.push_back(next);
        }
    }
    ++shells;
  }
  s.shell_walls.assign(shells, Wall::outward);
  s.shell_tangled.assign(shells, 0);
}

void find_normals(Solid& s) {
  s.vertex_normals.assign(s.vertices.size(), Vec3::Zero());
  s.triangle_normals.reserve(s.triangles.size());
  auto unit = [](const Vec3& v) {
    const double length = v.norm();
    return length > 0 ? Vec3(v / length) : Vec3(Vec3::Zero());
  };
  for (const auto& t : s.triangles) {
    const Vec3 n = (s.vertices[t[1]] - s.vertices[t[0]]).cross(s.vertices[t[2]] - s.vertices[t[0]]);
    for (const Index v : t) s.vertex_normals[v] += n;
    s.triangle_normals.push_back(unit(n));
  }
  for (Vec3& n : s.vertex_normals) n = unit(n);
}

/// The integral of x·xᵀ over a triangle of area A is A/12 · (aaᵀ + bbᵀ + ccᵀ + ssᵀ), s = a + b + c.
void find_spread(Solid& s) {
  geom::Mat3 second = geom::Mat3::Zero();
  Vec3 first = Vec3::Zero();
  double area = 0;
  for (const auto& t : s.triangles) {
    const Vec3& a = s.vertices[t[0]];
    const Vec3& b = s.vertices[t[1]];
    const Vec3& c = s.vertices[t[2]];
    const double w = 0.5 * (b - a).cross(c - a).norm();
    const Vec3 sum = a + b + c;
    second += w / 12 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
    first += w / 3 * sum;
    area += w;
  }
  if (area > 0) s.spread = second / area - first * first.transpose() / (area * area);
}

void lay_in_columns(Solid& s) {
  s.areas.assign(s.triangles.size());
  s.middles.assign(s.triangles.size());
  s.triangle_normals_near.assign(s.triangles.size());
  s.vertex_normals_near.assign(s.vertices.size());
  for (std::size_t t = 0; t < s.triangles.size(); ++t) {
    const Vec3& a = s.vertices[s.triangles[t][0]];
    const Vec3& b = s.vertices[s.triangles[t][1]];
    const Vec3& c = s.vertices[s.triangles[t][2]];
    s.areas.set(t, Vec3(0.5 * (b - a).cross(c - a)));
    s.middles.set(t, Vec3((a + b + c) / 3));
    s.triangle_normals_near.set(t, s.triangle_normals[t]);
  }
  for (std::size_t v = 0; v < s.vertices.size(); ++v) s.vertex_normals_near.set(v, s.vertex_normals[v]);
}

void find_facets_at(Solid& s) {
  s.first_facet_at.assign(s.vertices.size() + 1, 0);
  for (const auto& t : s.triangles)
    for (const Index v : t) ++s.first_facet_at[v + 1];
  std::partial_sum(s.first_facet_at.begin(), s.first_facet_at.end(), s.first_facet_at.begin());
  s.facets_at.resize(3 * s.triangles.size());
  std::vector<Index> next(s.first_facet_at.begin(), s.first_facet_at.end() - 1);
  for (Index t = 0; t < s.triangles.size(); ++t)
    for (const Index v : s.triangles[t]) s.facets_at[next[v]++] = t;
}

/// Vertices, facets and shells as they come.
Solid begin_solid(const mesh::TriangleMesh& mesh) {
  Solid s;
  const mesh::Bounds box = mesh::bounds(mesh);
  const Vec3 middle = 0.5 * (box.min + box.max);
  s.vertices.reserve(mesh.vertices.size());
  for (const Vec3& v : mesh.vertices) s.vertices.push_back(v - middle);
  s.box_mm3 = box.size().prod();
  s.triangles = mesh.triangles;
  for (const Vec3& v : s.vertices) s.radius_mm = std::max(s.radius_mm, v.norm());
  s.centre_of_mass = mesh::centroid(mesh) - middle;
  s.signed_volume_mm3 = mesh::volume(mesh);
  lay_out(s);
  find_neighbours(s);
  find_shells(s);
  find_normals(s);
  return s;
}

}  // namespace

Solid prepare_standing(const mesh::TriangleMesh& mesh, const run::Context& ctx) {
  Solid s = begin_solid(mesh);
  settle_facets(s, ctx);
  find_facets_at(s);
  return s;
}

Solid prepare_solid(const mesh::TriangleMesh& mesh, const run::Context& ctx) {
  Solid s = begin_solid(mesh);
  find_spread(s);
  settle_fill(s, ctx);
  lay_in_columns(s);
  find_facets_at(s);
  return s;
}

}  // namespace voidpath::orient
