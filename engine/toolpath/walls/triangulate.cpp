#include "engine/toolpath/walls/triangulate.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <queue>
#include <unordered_map>

namespace voidpath::toolpath {

namespace {

using geom::Point;
using Index = std::uint32_t;
using Chain = std::vector<Index>;

/// Twice the signed area, nm². Slivers are far smaller than the ±1.07 m for which this is exact enough in
/// double; it decides by sign only.
double turn(const Point& a, const Point& b, const Point& c) {
  return static_cast<double>(b.x - a.x) * static_cast<double>(c.y - a.y) -
         static_cast<double>(b.y - a.y) * static_cast<double>(c.x - a.x);
}

bool in_triangle(const Point& a, const Point& b, const Point& c, const Point& p) {
  return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
}

/// Points this near to the circle, relative to its size to the fourth power, count as on it.
constexpr double kCircleSlack = 1e-12;

/// Whether d lies in the circle through a, b, c (counter-clockwise).
bool in_circle(const Point& a, const Point& b, const Point& c, const Point& d) {
  const auto ax = static_cast<double>(a.x - d.x), ay = static_cast<double>(a.y - d.y);
  const auto bx = static_cast<double>(b.x - d.x), by = static_cast<double>(b.y - d.y);
  const auto cx = static_cast<double>(c.x - d.x), cy = static_cast<double>(c.y - d.y);
  const double a2 = ax * ax + ay * ay, b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
  const double det = ax * (by * c2 - b2 * cy) - ay * (bx * c2 - b2 * cx) + a2 * (bx * cy - by * cx);
  return det > kCircleSlack * (a2 + b2 + c2) * (a2 + b2 + c2);
}

class Triangulator {
 public:
  Triangulation run(const geom::Region& region) {
    Chain chain = add(region.outer);
    std::vector<Chain> holes;
    for (const auto& hole : region.holes) holes.push_back(add(hole));
    // From the right: a hole's cut then meets no hole that is still to come.
    std::stable_sort(holes.begin(), holes.end(),
                     [&](const Chain& a, const Chain& b) { return rightmost(a).x > rightmost(b).x; });
    for (const Chain& hole : holes) cut_to(chain, hole);
    clip_ears(std::move(chain));
    if (!connect()) return {};
    flip_all();
    return std::move(out_);
  }

 private:
  Chain add(const geom::Ring& ring) {
    Chain chain;
    for (const Point& p : ring) {
      chain.push_back(static_cast<Index>(out_.points.size()));
      out_.points.push_back(p);
    }
    return chain;
  }
  const Point& at(Index i) const { return out_.points[i]; }
  const Point& rightmost(const Chain& chain) const {
    return at(*std::max_element(chain.begin(), chain.end(), [&](Index a, Index b) { return at(a) < at(b); }));
  }

  /// Joins a hole to the chain by a cut from its rightmost vertex to one that sees it.
  void cut_to(Chain& chain, const Chain& hole) {
    if (hole.empty()) return;
    const auto start = static_cast<std::size_t>(
        std::max_element(hole.begin(), hole.end(), [&](Index a, Index b) { return at(a) < at(b); }) -
        hole.begin());
    const Point m = at(hole[start]);
    // The nearest edge straight to the right, and its further end.
    double best = std::numeric_limits<double>::max();
    std::size_t pick = chain.size();
    for (std::size_t i = 0; i < chain.size(); ++i) {
      const std::size_t j = (i + 1) % chain.size();
      const Point& a = at(chain[i]);
      const Point& b = at(chain[j]);
      if ((a.y > m.y) == (b.y > m.y)) continue;
      const double t = static_cast<double>(m.y - a.y) / static_cast<double>(b.y - a.y);
      const double x = static_cast<double>(a.x) + t * static_cast<double>(b.x - a.x);
      if (x < static_cast<double>(m.x) || x >= best) continue;
      best = x;
      pick = a.x > b.x ? i : j;
    }
    if (pick == chain.size()) return;
    // A vertex inside the triangle of m, the edge and that end hides it: take the one nearest in angle.
    const Point hit{static_cast<geom::Coord>(best), m.y};
    const Point end = at(chain[pick]);
    double slope = std::numeric_limits<double>::max();
    const bool above = end.y > m.y;
    for (std::size_t i = 0; i < chain.size(); ++i) {
      const Point& p = at(chain[i]);
      if (p.x <= m.x || !(above ? in_triangle(m, hit, end, p) : in_triangle(m, end, hit, p))) continue;
      if (!sees(chain, i, m)) continue;
      const double s = static_cast<double>(above ? p.y - m.y : m.y - p.y) / static_cast<double>(p.x - m.x);
      if (s < slope || (s == slope && p.x < at(chain[pick]).x)) slope = s, pick = i;
    }
    Chain joined(chain.begin(), chain.begin() + static_cast<std::ptrdiff_t>(pick) + 1);
    for (std::size_t k = 0; k <= hole.size(); ++k) joined.push_back(hole[(start + k) % hole.size()]);
    joined.insert(joined.end(), chain.begin() + static_cast<std::ptrdiff_t>(pick), chain.end());
    chain = std::move(joined);
  }

  /// Whether the chain's inside, at its vertex i, opens towards m. Vertices of earlier cuts come twice, and
  /// only one of them does.
  bool sees(const Chain& chain, std::size_t i, const Point& m) const {
    const Point& before = at(chain[(i + chain.size() - 1) % chain.size()]);
    const Point& p = at(chain[i]);
    const Point& after = at(chain[(i + 1) % chain.size()]);
    const bool left_of_in = turn(before, p, m) > 0;
    const bool left_of_out = turn(p, after, m) > 0;
    return turn(before, p, after) > 0 ? left_of_in && left_of_out : left_of_in || left_of_out;
  }

  /// What is not yet clipped, as a ring of places in the chain.
  struct Ring {
    Chain vertex;
    std::vector<std::uint32_t> prev;
    std::vector<std::uint32_t> next;
    std::vector<std::uint32_t> version;  ///< of a place's latest measure
    std::vector<char> left;              ///< whether the place is still there
    std::uint32_t any = 0;               ///< one that is
    std::size_t size = 0;

    explicit Ring(Chain chain) : vertex(std::move(chain)), version(vertex.size()), left(vertex.size(), 1) {
      size = vertex.size();
      for (std::uint32_t i = 0; i < size; ++i) {
        prev.push_back(i > 0 ? i - 1 : static_cast<std::uint32_t>(size) - 1);
        next.push_back(i + 1 < size ? i + 1 : 0);
      }
    }
    void take_out(std::uint32_t i) {
      next[prev[i]] = next[i];
      prev[next[i]] = prev[i];
      left[i] = 0;
      any = next[i];
      --size;
    }
    template <class Use>
    void each(Use use) const {
      std::uint32_t i = any;
      for (std::size_t k = 0; k < size; ++k, i = next[i]) use(i);
    }
  };

  /// An ear by the length of its cut; one whose place was measured again since is out of date.
  struct Ear {
    double cut;
    std::uint32_t place;
    std::uint32_t version;
    friend auto operator<=>(const Ear&, const Ear&) = default;
  };
  using Ears = std::priority_queue<Ear, std::vector<Ear>, std::greater<>>;

  /// Length of the side that would cut off the vertex at place i; infinite where that is no ear.
  double cut_at(const Ring& ring, std::uint32_t i) const {
    const Point &a = at(ring.vertex[ring.prev[i]]), &b = at(ring.vertex[i]),
                &c = at(ring.vertex[ring.next[i]]);
    if (turn(a, b, c) <= 0) return kNoEar;
    const auto [left, right] = std::minmax({a.x, b.x, c.x});
    const auto [low, high] = std::minmax({a.y, b.y, c.y});
    auto v = std::lower_bound(by_x_.begin(), by_x_.end(), left,
                              [&](Index k, geom::Coord x) { return at(k).x < x; });
    for (; v != by_x_.end() && at(*v).x <= right; ++v) {
      const Point& p = at(*v);
      if (in_chain_[*v] == 0 || p.y < low || p.y > high) continue;
      if (p != a && p != b && p != c && in_triangle(a, b, c, p)) return kNoEar;
    }
    return geom::distance(a, c);
  }

  void measure(Ring& ring, Ears& ears, std::uint32_t i) const {
    const double cut = cut_at(ring, i);
    ++ring.version[i];
    if (cut < kNoEar) ears.push({cut, i, ring.version[i]});
  }

  /// The ear with the shortest cut, taken off the queue; nothing if there is none.
  static std::optional<std::uint32_t> take_ear(const Ring& ring, Ears& ears) {
    while (!ears.empty()) {
      const Ear ear = ears.top();
      ears.pop();
      if (ring.left[ear.place] && ring.version[ear.place] == ear.version) return ear.place;
    }
    return std::nullopt;
  }

  /// Clips the ear with the shortest cut first: across a sliver, not along it.
  void clip_ears(Chain chain) {
    by_x_.resize(out_.points.size());
    std::iota(by_x_.begin(), by_x_.end(), Index{0});
    std::sort(by_x_.begin(), by_x_.end(), [&](Index a, Index b) { return at(a) < at(b); });
    in_chain_.assign(out_.points.size(), 0);
    for (const Index v : chain) ++in_chain_[v];
    Ring ring(std::move(chain));
    Ears ears;
    auto measure_all = [&] { ring.each([&](std::uint32_t i) { measure(ring, ears, i); }); };
    measure_all();
    while (ring.size > 3) {
      std::optional<std::uint32_t> ear = take_ear(ring, ears);
      if (!ear) {  // vertices clipped since may have uncovered some
        measure_all();
        ear = take_ear(ring, ears);
      }
      if (!ear) ear = flat_corner(ring);
      if (!ear) return;
      const std::uint32_t before = ring.prev[*ear], after = ring.next[*ear];
      add_triangle(ring, *ear);
      --in_chain_[ring.vertex[*ear]];
      ring.take_out(*ear);
      measure(ring, ears, before);
      measure(ring, ears, after);
    }
    if (ring.size == 3) add_triangle(ring, ring.any);
  }

  void add_triangle(const Ring& ring, std::uint32_t i) {
    out_.triangles.push_back({{ring.vertex[ring.prev[i]], ring.vertex[i], ring.vertex[ring.next[i]]}, {}});
  }

  /// What is left when there are no ears has no area: its corners go as they are, never reflex ones.
  std::optional<std::uint32_t> flat_corner(const Ring& ring) const {
    std::optional<std::uint32_t> found;
    ring.each([&](std::uint32_t i) {
      if (!found &&
          turn(at(ring.vertex[ring.prev[i]]), at(ring.vertex[i]), at(ring.vertex[ring.next[i]])) == 0)
        found = i;
    });
    return found;
  }

  static std::uint64_t key(Index a, Index b) { return (std::uint64_t{a} << 32) | b; }

  bool connect() {
    std::unordered_map<std::uint64_t, Index> sides;
    sides.reserve(out_.triangles.size() * 3);
    for (Index t = 0; t < out_.triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& c = out_.triangles[t].corner;
        if (!sides.emplace(key(c[k], c[(k + 1) % 3]), t).second) return false;
      }
    for (auto& t : out_.triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto twin = sides.find(key(t.corner[(k + 1) % 3], t.corner[k]));
        t.neighbour[k] = twin == sides.end() ? Triangulation::kBorder : twin->second;
      }
    return true;
  }

  void replace(Index triangle, Index from, Index to) {
    if (triangle == Triangulation::kBorder) return;
    for (auto& n : out_.triangles[triangle].neighbour)
      if (n == from) {
        n = to;
        return;
      }
  }

  /// Turns the side between two triangles into the other diagonal of their quadrilateral if that is better.
  bool flip(Index t, std::size_t k) {
    const Index u = out_.triangles[t].neighbour[k];
    if (u == Triangulation::kBorder) return false;
    auto& a = out_.triangles[t];
    auto& b = out_.triangles[u];
    std::size_t m = 0;
    while (m < 3 && b.corner[m] != a.corner[(k + 1) % 3]) ++m;
    if (m == 3 || b.corner[(m + 1) % 3] != a.corner[k]) return false;
    const Index p = a.corner[k], q = a.corner[(k + 1) % 3], r = a.corner[(k + 2) % 3],
                s = b.corner[(m + 2) % 3];
    if (turn(at(p), at(s), at(r)) <= 0 || turn(at(s), at(q), at(r)) <= 0) return false;
    if (!in_circle(at(p), at(q), at(r), at(s)) && turn(at(p), at(q), at(r)) > 0) return false;
    const Index n_qr = a.neighbour[(k + 1) % 3], n_rp = a.neighbour[(k + 2) % 3];
    const Index n_ps = b.neighbour[(m + 1) % 3], n_sq = b.neighbour[(m + 2) % 3];
    a = {{p, s, r}, {n_ps, u, n_rp}};
    b = {{s, q, r}, {n_sq, n_qr, t}};
    replace(n_ps, u, t);
    replace(n_qr, t, u);
    return true;
  }

  void flip_all() {
    for (int pass = 0; pass < kMaxPasses; ++pass) {
      bool changed = false;
      for (Index t = 0; t < out_.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) changed = flip(t, k) || changed;
      if (!changed) return;
    }
  }

  /// Lawson's flips end by themselves; this bounds them should rounding make two diagonals equal.
  static constexpr int kMaxPasses = 50;
  static constexpr double kNoEar = std::numeric_limits<double>::infinity();
  Triangulation out_;
  std::vector<Index> by_x_;    ///< all points from left to right
  std::vector<int> in_chain_;  ///< how often each is a corner of what is not yet clipped
};

}  // namespace

Triangulation triangulate(const geom::Region& region) {
  if (region.outer.size() < 3) return {};
  return Triangulator().run(region);
}

}  // namespace voidpath::toolpath
