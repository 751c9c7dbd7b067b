#include "tests/engine/orient/reference.h"

#include "tests/support/meshes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include <catch2/catch.hpp>

namespace voidpath::test {

namespace {

using geom::Vec3;
using mesh::TriangleMesh;

struct P {
  double x, y;
};
using Loop = std::vector<P>;

/// A vertex that is below a slice by less counts as above it: the engine's stated rule. mm
constexpr double kLevel = 1e-6;

struct Seen {
  std::vector<Vec3> v;  ///< x, y across; z along the direction
};

Seen look(const TriangleMesh& m, const Vec3& d) {
  const Vec3 n = d.normalized();
  const Vec3 e1 = n.unitOrthogonal();
  const Vec3 e2 = n.cross(e1);
  Seen s;
  for (const Vec3& p : m.vertices) s.v.emplace_back(p.dot(e1), p.dot(e2), p.dot(n));
  return s;
}

std::vector<double> critical_heights(const TriangleMesh& m, const Seen& s, const Vec3& d,
                                     const ReferenceOptions& o) {
  std::vector<double> h;
  std::vector<Vec3> normals(m.vertices.size(), Vec3::Zero());
  std::vector<int> changes(m.vertices.size(), 0);
  const double limit = std::cos(o.normal_tolerance_deg * std::numbers::pi / 180) - 1e-12;
  auto near = [&](const Vec3& n) {
    return n.norm() > 0 && std::abs(n.normalized().dot(d.normalized())) >= limit;
  };
  auto above = [&](unsigned a, unsigned b) {
    return s.v[a].z() != s.v[b].z() ? s.v[a].z() > s.v[b].z() : a > b;
  };
  for (const auto& t : m.triangles) {
    const Vec3 n = (m.vertices[t[1]] - m.vertices[t[0]]).cross(m.vertices[t[2]] - m.vertices[t[0]]);
    if (!o.morse && near(n)) h.push_back((s.v[t[0]].z() + s.v[t[1]].z() + s.v[t[2]].z()) / 3);
    for (int k = 0; k < 3; ++k) {
      const unsigned v = t[static_cast<std::size_t>(k)];
      normals[v] += n;
      if (above(t[static_cast<std::size_t>((k + 1) % 3)], v) !=
          above(t[static_cast<std::size_t>((k + 2) % 3)], v))
        ++changes[v];
    }
  }
  for (std::size_t v = 0; v < m.vertices.size(); ++v)
    if (o.morse ? changes[v] != 2 : near(normals[v])) h.push_back(s.v[v].z());
  for (const Vec3& p : s.v) h.push_back(p.z());  // for the ends; thinned out below
  const auto [low, high] = std::minmax_element(h.begin(), h.end());
  const double lowest = *low;
  const double highest = *high;
  h.resize(h.size() - s.v.size());
  h.push_back(lowest);
  h.push_back(highest);
  std::sort(h.begin(), h.end());
  const double step = (o.morse ? 0 : o.min_slab_mm) + 1e-6;
  std::vector<double> kept{lowest};
  for (const double x : h)
    if (x - kept.back() > step && highest - x > 1e-6) kept.push_back(x);
  kept.push_back(highest);
  return kept;
}

std::vector<Loop> cut(const TriangleMesh& m, const Seen& s, double z) {
  using Edge = std::pair<unsigned, unsigned>;
  std::map<Edge, std::vector<Edge>> next;
  for (const auto& t : m.triangles) {
    Edge from{};
    Edge to{};
    bool crossed = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const unsigned a = t[k];
      const unsigned b = t[(k + 1) % 3];
      const bool up_a = s.v[a].z() + kLevel >= z;
      const bool up_b = s.v[b].z() + kLevel >= z;
      if (up_a && !up_b) from = std::minmax(a, b);
      if (!up_a && up_b) to = std::minmax(a, b), crossed = true;
    }
    if (crossed) next[from].push_back(to);
  }
  std::vector<Loop> loops;
  for (auto& [start, targets] : next)
    while (!targets.empty()) {
      Loop loop;
      for (Edge at = start;;) {
        auto& out = next[at];
        if (out.empty()) break;
        at = out.back();
        out.pop_back();
        const Vec3& a = s.v[at.first];
        const Vec3& b = s.v[at.second];
        const double r = std::clamp((z - a.z()) / (b.z() - a.z()), 0.0, 1.0);
        loop.push_back({a.x() + r * (b.x() - a.x()), a.y() + r * (b.y() - a.y())});
        if (at == start) break;
      }
      loops.push_back(loop);
    }
  return loops;
}

double loop_area(const Loop& l) {
  double a = 0;
  for (std::size_t i = 0; i < l.size(); ++i) {
    const P& p = l[i];
    const P& q = l[(i + 1) % l.size()];
    a += (p.x - l[0].x) * (q.y - l[0].y) - (q.x - l[0].x) * (p.y - l[0].y);
  }
  return a / 2;
}

bool in_loop(const Loop& l, P p) {
  bool in = false;
  for (std::size_t i = 0; i < l.size(); ++i) {
    const P& a = l[i];
    const P& b = l[(i + 1) % l.size()];
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) in = !in;
  }
  return in;
}

double point_segment(P p, P a, P b) {
  const double l2 = (b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y);
  double t = l2 > 0 ? ((p.x - a.x) * (b.x - a.x) + (p.y - a.y) * (b.y - a.y)) / l2 : 0;
  t = std::min(1.0, std::max(0.0, t));
  return std::hypot(a.x + t * (b.x - a.x) - p.x, a.y + t * (b.y - a.y) - p.y);
}

double loop_distance(const Loop& a, const Loop& b) {
  double best = 1e300;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) {
      const P p = a[i];
      const P q = a[(i + 1) % a.size()];
      const P r = b[j];
      const P t = b[(j + 1) % b.size()];
      best = std::min({best, point_segment(p, r, t), point_segment(q, r, t), point_segment(r, p, q),
                       point_segment(t, p, q)});
    }
  return best;
}

/// Regions and mean distance of a slice: nesting depth by even-odd counting.
std::pair<double, double> measure(const std::vector<Loop>& all) {
  std::vector<Loop> loops;
  for (const Loop& l : all)
    if (std::abs(loop_area(l)) > 1e-9) loops.push_back(l);
  const std::size_t n = loops.size();
  std::vector<std::vector<bool>> holds(n, std::vector<bool>(n, false));
  std::vector<int> depth(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const P p{(loops[i][0].x + loops[i][1].x) / 2, (loops[i][0].y + loops[i][1].y) / 2};
    for (std::size_t j = 0; j < n; ++j)
      if (i != j && std::abs(loop_area(loops[j])) > std::abs(loop_area(loops[i])) && in_loop(loops[j], p))
        holds[j][i] = true, ++depth[i];
  }
  std::vector<std::vector<std::size_t>> regions;
  for (std::size_t i = 0; i < n; ++i) {
    if (depth[i] % 2 != 0) continue;
    std::vector<std::size_t> r{i};
    for (std::size_t j = 0; j < n; ++j)
      if (holds[i][j] && depth[j] == depth[i] + 1) r.push_back(j);
    regions.push_back(r);
  }
  double sum = 0;
  double pairs = 0;
  for (std::size_t i = 0; i < regions.size(); ++i)
    for (std::size_t j = i + 1; j < regions.size(); ++j) {
      double best = 1e300;
      for (const std::size_t a : regions[i])
        for (const std::size_t b : regions[j]) best = std::min(best, loop_distance(loops[a], loops[b]));
      sum += best;
      pairs += 1;
    }
  return {static_cast<double>(regions.size()), pairs > 0 ? sum / pairs : 0};
}

struct Bounds2 {
  Vec3 low, high;
};
Bounds2 bounds_of(const Seen& s) {
  Bounds2 b{s.v[0], s.v[0]};
  for (const Vec3& p : s.v) {
    b.low = b.low.cwiseMin(p);
    b.high = b.high.cwiseMax(p);
  }
  return b;
}

/// Sum of the gaps along vertical lines: below, between and inside material of non-zero winding.
double trapped(const TriangleMesh& m, const Seen& s, int columns) {
  const auto [low, high] = bounds_of(s);
  const auto n = static_cast<std::size_t>(columns);
  const double dx = (high.x() - low.x()) / columns;
  const double dy = (high.y() - low.y()) / columns;
  struct Hit {
    double z;
    int up;
  };
  std::vector<std::vector<Hit>> lines(n * n);
  for (const auto& t : m.triangles) {
    const Vec3& a = s.v[t[0]];
    const Vec3& b = s.v[t[1]];
    const Vec3& c = s.v[t[2]];
    const double det = (b.x() - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (b.y() - a.y());
    if (det == 0) continue;
    auto first = [](double v, double from, double step) {
      return std::max(0, static_cast<int>((v - from) / step) - 1);
    };
    const int i1 = std::min(columns - 1, first(std::max({a.x(), b.x(), c.x()}), low.x(), dx) + 2);
    const int j1 = std::min(columns - 1, first(std::max({a.y(), b.y(), c.y()}), low.y(), dy) + 2);
    for (int i = first(std::min({a.x(), b.x(), c.x()}), low.x(), dx); i <= i1; ++i)
      for (int j = first(std::min({a.y(), b.y(), c.y()}), low.y(), dy); j <= j1; ++j) {
        // Off the middle of the cell by an odd share, so that lines miss the edges of plain shapes.
        const double x = low.x() + (i + 0.5137) * dx;
        const double y = low.y() + (j + 0.4871) * dy;
        const double u = ((x - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (y - a.y())) / det;
        const double v = ((b.x() - a.x()) * (y - a.y()) - (x - a.x()) * (b.y() - a.y())) / det;
        if (u < 0 || v < 0 || u + v > 1) continue;
        lines[static_cast<std::size_t>(i) * n + static_cast<std::size_t>(j)].push_back(
            {a.z() + u * (b.z() - a.z()) + v * (c.z() - a.z()), det > 0 ? 1 : -1});
      }
  }
  double sum = 0;
  for (auto& line : lines) {
    std::sort(line.begin(), line.end(), [](const Hit& p, const Hit& q) { return p.z < q.z; });
    double below = low.z();
    int winding = 0;
    for (const Hit& h : line) {
      if (winding == 0) sum += h.z - below;
      winding -= h.up;
      below = h.z;
    }
  }
  return sum * dx * dy;
}

}  // namespace

double bounding_volume(const TriangleMesh& mesh, const Vec3& d) {
  const auto [low, high] = bounds_of(look(mesh, d));
  return (high - low).prod();
}

orient::Criteria reference_criteria(const TriangleMesh& mesh, const Vec3& d,
                                    const ReferenceOptions& options) {
  const Seen s = look(mesh, d);
  const std::vector<double> h = critical_heights(mesh, s, d, options);
  orient::Criteria c;
  c.height_mm = h.back() - h.front();
  for (std::size_t i = 0; i + 1 < h.size(); ++i) {
    const auto [count, distance] = measure(cut(mesh, s, (h[i] + h[i + 1]) / 2));
    const double share = (h[i + 1] - h[i]) / c.height_mm;
    c.contours += share * count;
    c.void_mm += share * distance;
  }
  c.trapped_mm3 = trapped(mesh, s, options.columns);
  return c;
}

TEST_CASE("the reference gives the closed forms of a table") {
  const TriangleMesh m = table(40, 30, 20, 4, 5);
  const orient::Criteria c = reference_criteria(m, Vec3::UnitZ());
  CHECK(c.height_mm == Approx(20));
  CHECK(c.contours == Approx((4 * 16 + 4) / 20.0));
  CHECK(c.void_mm == Approx(0.8 * (2 * 30 + 2 * 20 + 2 * std::hypot(30, 20)) / 6));
  CHECK(c.trapped_mm3 == Approx((40 * 30 - 4 * 25) * 16.0).epsilon(0.01));
}

}  // namespace voidpath::test
