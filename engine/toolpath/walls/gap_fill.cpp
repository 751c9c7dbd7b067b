#include "engine/toolpath/walls/gap_fill.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/walls/triangulate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace voidpath::toolpath {

namespace {

using geom::Point;

/// Borders are divided into steps no longer than this, mm, so that triangles lie across the area: about the
/// width of the areas in question.
constexpr double kStepMm = 0.4;
/// Detail of the border below this is dropped before, mm.
constexpr double kToleranceMm = 0.02;
/// A branch shorter than this share of the width where it leaves the main line only points into a corner.
constexpr double kMinBranch = 1.0;

geom::Ring divided(const geom::Ring& ring) {
  geom::Ring out;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point& a = ring[i];
    const Point& b = ring[(i + 1) % ring.size()];
    const auto parts = std::max<std::int64_t>(
        1, static_cast<std::int64_t>(std::ceil(geom::distance(a, b) / (kStepMm * geom::kNmPerMm))));
    for (std::int64_t k = 0; k < parts; ++k)
      out.push_back({a.x + (b.x - a.x) * k / parts, a.y + (b.y - a.y) * k / parts});
  }
  return out;
}

double to_segment_mm(const Point& p, const Point& a, const Point& b) {
  const auto dx = static_cast<double>(b.x - a.x), dy = static_cast<double>(b.y - a.y);
  const auto px = static_cast<double>(p.x - a.x), py = static_cast<double>(p.y - a.y);
  const double len2 = dx * dx + dy * dy;
  const double t = len2 > 0 ? std::clamp((px * dx + py * dy) / len2, 0.0, 1.0) : 0.0;
  return std::hypot(px - t * dx, py - t * dy) / geom::kNmPerMm;
}

/// The middle lines as a graph: nodes in the middle of inner sides and of triangles where lines meet.
class Skeleton {
 public:
  explicit Skeleton(const Triangulation& mesh) : mesh_(mesh) {
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) add(t);
  }

  std::vector<CentreLine> lines() {
    prune();
    // As few lines as can be (Euler): each begins and ends at an end or a meeting of an odd number, and goes
    // straight on through the meetings between.
    std::vector<CentreLine> out;
    for (std::uint32_t n = 0; n < nodes_.size(); ++n)
      if (nodes_[n].links.size() == 1) out.push_back(trace(n));
    for (std::uint32_t n = 0; n < nodes_.size(); ++n)
      if (nodes_[n].links.size() % 2 == 1) out.push_back(trace(n));
    for (std::uint32_t n = 0; n < nodes_.size(); ++n)
      while (!nodes_[n].links.empty()) out.push_back(trace(n));
    return out;
  }

 private:
  struct Node {
    Point p;
    double width_mm = 0;
    std::vector<std::uint32_t> links;
  };

  void add(std::uint32_t t) {
    const auto& tri = mesh_.triangles[t];
    std::array<std::uint32_t, 3> inner{};
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k)
      if (tri.neighbour[k] != Triangulation::kBorder) inner[count++] = side_node(t, k);
    if (count == 2) link(inner[0], inner[1]);
    if (count == 3) {
      Node node;
      for (const std::uint32_t c : tri.corner) {
        node.p.x += mesh_.points[c].x;
        node.p.y += mesh_.points[c].y;
      }
      node.p = {node.p.x / 3, node.p.y / 3};
      for (const std::uint32_t n : inner) node.width_mm = std::max(node.width_mm, nodes_[n].width_mm);
      nodes_.push_back(node);
      for (const std::uint32_t n : inner) link(static_cast<std::uint32_t>(nodes_.size() - 1), n);
    }
  }

  std::uint32_t side_node(std::uint32_t t, std::size_t k) {
    const auto& tri = mesh_.triangles[t];
    const std::uint32_t a = tri.corner[k], b = tri.corner[(k + 1) % 3];
    const auto [it, fresh] =
        by_side_.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(nodes_.size()));
    if (fresh) {
      Node node;
      const Point &p = mesh_.points[a], &q = mesh_.points[b];
      node.p = {(p.x + q.x) / 2, (p.y + q.y) / 2};
      node.width_mm =
          std::min(geom::distance(p, q) / geom::kNmPerMm,
                   2 * std::min(border_distance(t, node.p), border_distance(tri.neighbour[k], node.p)));
      nodes_.push_back(node);
    }
    return it->second;
  }

  /// From a point to the border sides of a triangle; far where it has none.
  double border_distance(std::uint32_t t, const Point& p) const {
    double best = 1e9;
    const auto& tri = mesh_.triangles[t];
    for (std::size_t k = 0; k < 3; ++k)
      if (tri.neighbour[k] == Triangulation::kBorder)
        best = std::min(best,
                        to_segment_mm(p, mesh_.points[tri.corner[k]], mesh_.points[tri.corner[(k + 1) % 3]]));
    return best;
  }

  void link(std::uint32_t a, std::uint32_t b) {
    nodes_[a].links.push_back(b);
    nodes_[b].links.push_back(a);
  }
  void unlink(std::uint32_t a, std::uint32_t b) {
    std::erase(nodes_[a].links, b);
    std::erase(nodes_[b].links, a);
  }

  double step_mm(std::uint32_t a, std::uint32_t b) const {
    return geom::distance(nodes_[a].p, nodes_[b].p) / geom::kNmPerMm;
  }

  /// Takes away branches that end before they have gone as far as the area is wide. All that leave from one
  /// meeting go together: a strip's end forks into its two corners.
  void prune() {
    std::vector<std::vector<std::uint32_t>> doomed;
    for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
      if (nodes_[n].links.size() != 1) continue;
      std::vector<std::uint32_t> branch{n};
      double length = 0;
      std::uint32_t from = n;
      std::uint32_t at = nodes_[n].links.front();
      while (nodes_[at].links.size() == 2) {
        length += step_mm(from, at);
        branch.push_back(at);
        const std::uint32_t next = nodes_[at].links[nodes_[at].links[0] == from ? 1 : 0];
        from = at;
        at = next;
      }
      length += step_mm(from, at);
      if (nodes_[at].links.size() < 3 || length > kMinBranch * nodes_[at].width_mm) continue;
      branch.push_back(at);
      doomed.push_back(std::move(branch));
    }
    for (const auto& branch : doomed)
      for (std::size_t k = 0; k + 1 < branch.size(); ++k) unlink(branch[k], branch[k + 1]);
  }

  /// The link that leads most nearly straight on; any of them at a line's beginning.
  std::uint32_t straight_on(std::uint32_t before, std::uint32_t at) const {
    const auto& links = nodes_[at].links;
    if (before == at || links.size() == 1) return links.front();
    const Point &p = nodes_[before].p, &q = nodes_[at].p;
    double best = -2;
    std::uint32_t pick = links.front();
    for (const std::uint32_t next : links) {
      const Point& r = nodes_[next].p;
      const auto ux = static_cast<double>(q.x - p.x), uy = static_cast<double>(q.y - p.y);
      const auto vx = static_cast<double>(r.x - q.x), vy = static_cast<double>(r.y - q.y);
      const double cosine = (ux * vx + uy * vy) / std::max(std::hypot(ux, uy) * std::hypot(vx, vy), 1.0);
      if (cosine > best) best = cosine, pick = next;
    }
    return pick;
  }

  /// Follows a line from a node as far as there is one, and takes it out of the graph.
  CentreLine trace(std::uint32_t start) {
    CentreLine out;
    auto put = [&](std::uint32_t n) {
      out.points.push_back(nodes_[n].p);
      out.width_mm.push_back(nodes_[n].width_mm);
    };
    put(start);
    std::uint32_t before = start;
    std::uint32_t at = start;
    while (!nodes_[at].links.empty()) {
      const std::uint32_t next = straight_on(before, at);
      unlink(at, next);
      put(next);
      before = at;
      at = next;
    }
    out.closed = at == start && out.points.size() > 3;
    return out;
  }

  const Triangulation& mesh_;
  std::vector<Node> nodes_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> by_side_;
};

}  // namespace

std::vector<CentreLine> centre_lines(const geom::Region& area) {
  std::vector<CentreLine> out;
  for (const geom::Region& plain : geom::simplify({area}, geom::from_mm(kToleranceMm))) {
    geom::Region region{divided(plain.outer), {}};
    for (const auto& hole : plain.holes) region.holes.push_back(divided(hole));
    const Triangulation mesh = triangulate(region);
    for (auto& line : Skeleton(mesh).lines()) out.push_back(std::move(line));
  }
  return out;
}

}  // namespace voidpath::toolpath
