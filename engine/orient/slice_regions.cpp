#include "engine/orient/slice_regions.h"

#include "engine/orient/segment_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voidpath::orient {

namespace {

constexpr std::size_t kLeaf = 4;  ///< segments to a leaf of a ring's box tree

template <class Box>
double gap2(const Box& a, const Box& b) {
  const double x = std::max({0.0, a.x0 - b.x1, b.x0 - a.x1});
  const double y = std::max({0.0, a.y0 - b.y1, b.y0 - a.y1});
  return x * x + y * y;
}

}  // namespace

SliceRegions::Ring SliceRegions::make_ring(const Contour& c) {
  const std::vector<Point2>& p = *points_;
  const std::size_t n = c.end - c.begin;
  std::size_t leaves = 1;
  while (leaves * kLeaf < n) leaves *= 2;
  Ring r{c.begin, c.end, c.area_mm2, boxes_.size(), leaves, {}, 0};
  constexpr double kFar = std::numeric_limits<double>::infinity();
  boxes_.resize(boxes_.size() + 2 * leaves, Box{kFar, kFar, -kFar, -kFar});
  Box* tree = boxes_.data() + r.tree;  // heap order from 1
  for (std::size_t i = 0; i < n; ++i) {
    Box& leaf = tree[leaves + i / kLeaf];
    for (const Point2 q : {p[c.begin + i], p[c.begin + (i + 1 == n ? 0 : i + 1)]}) {
      leaf.x0 = std::min(leaf.x0, q.x);
      leaf.y0 = std::min(leaf.y0, q.y);
      leaf.x1 = std::max(leaf.x1, q.x);
      leaf.y1 = std::max(leaf.y1, q.y);
    }
  }
  for (std::size_t i = leaves; i-- > 1;) {
    const Box& a = tree[2 * i];
    const Box& b = tree[2 * i + 1];
    tree[i] = {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
  }
  r.box = tree[1];
  r.hull = hulls_.add(p, c.begin, c.end);
  return r;
}

void SliceRegions::start(const std::vector<Point2>& points) {
  points_ = &points;
  outer_.clear();
  holes_.clear();
  boxes_.clear();
  hulls_.clear();
}

SliceMeasure SliceRegions::measure(const std::vector<Point2>& points, const std::vector<Contour>& contours) {
  start(points);
  std::size_t count = 0;
  for (const Contour& c : contours) count += c.area_mm2 > kLeastArea ? 1 : 0;
  if (count < 2) return {static_cast<double>(count), 0};
  for (const Contour& c : contours) {
    if (c.area_mm2 > kLeastArea) outer_.push_back(make_ring(c));
    if (c.area_mm2 < -kLeastArea) holes_.push_back(make_ring(c));
  }
  double sum = 0;
  for (std::size_t i = 0; i < outer_.size(); ++i)
    for (std::size_t j = i + 1; j < outer_.size(); ++j)
      sum += outer_[i].area > outer_[j].area ? region_distance(outer_[i], outer_[j])
                                             : region_distance(outer_[j], outer_[i]);
  const auto n = static_cast<double>(count);
  return {n, sum / (n * (n - 1) / 2)};
}

SliceMeasure SliceRegions::measure_told(const std::vector<Point2>& points,
                                        const std::vector<Contour>& contours) {
  start(points);
  std::vector<Index> regions;
  for (const Contour& c : contours)
    if (!c.is_inner) regions.push_back(c.region);
  std::sort(regions.begin(), regions.end());
  regions.erase(std::unique(regions.begin(), regions.end()), regions.end());
  if (regions.size() < 2) return {static_cast<double>(regions.size()), 0};
  told_.assign(regions.size(), {});
  for (const bool inner : {false, true})
    for (const Contour& c : contours) {
      if (c.is_inner != inner) continue;
      Told& t = told_[static_cast<std::size_t>(std::lower_bound(regions.begin(), regions.end(), c.region) -
                                               regions.begin())];
      t.rings.push_back(make_ring(c));
      if (inner) continue;
      const Box& b = t.rings.back().box;
      t.box = ++t.outline == 1 ? b
                               : Box{std::min(t.box.x0, b.x0), std::min(t.box.y0, b.y0),
                                     std::max(t.box.x1, b.x1), std::max(t.box.y1, b.y1)};
    }
  double sum = 0;
  for (std::size_t i = 0; i < told_.size(); ++i)
    for (std::size_t j = i + 1; j < told_.size(); ++j) sum += told_distance(told_[i], told_[j]);
  const auto n = static_cast<double>(told_.size());
  return {n, sum / (n * (n - 1) / 2)};
}

/// Where one region may lie in a hole of the other, that one's inner rings count too; elsewhere they are
/// further away than the outline.
double SliceRegions::told_distance(const Told& a, const Told& b) {
  auto around = [](const Box& p, const Box& q) {
    return p.x0 <= q.x0 && p.y0 <= q.y0 && p.x1 >= q.x1 && p.y1 >= q.y1;
  };
  const std::size_t rings_a = around(a.box, b.box) ? a.rings.size() : a.outline;
  const std::size_t rings_b = around(b.box, a.box) ? b.rings.size() : b.outline;
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < rings_a; ++i)
    for (std::size_t j = 0; j < rings_b; ++j)
      if (gap2(a.rings[i].box, b.rings[j].box) < best * best)
        best = std::min(best, distance(a.rings[i], b.rings[j]));
  return best;
}

bool SliceRegions::inside(const Ring& ring, Point2 p) const {
  const std::vector<Point2>& q = *points_;
  bool in = false;
  for (std::size_t i = ring.begin, j = ring.end - 1; i < ring.end; j = i++)
    if ((q[i].y > p.y) != (q[j].y > p.y) &&
        p.x < (q[j].x - q[i].x) * (p.y - q[i].y) / (q[j].y - q[i].y) + q[i].x)
      in = !in;
  return in;
}

/// Distance between filled areas; a is the larger. Where b lies in a hole of a, the nearest of a is that
/// hole's border; else the nearest of both are outer borders.
double SliceRegions::region_distance(const Ring& a, const Ring& b) {
  auto holds = [&](const Ring& outer, const Ring& inner) {
    return std::abs(outer.area) > std::abs(inner.area) && outer.box.x0 <= inner.box.x0 &&
           outer.box.y0 <= inner.box.y0 && outer.box.x1 >= inner.box.x1 && outer.box.y1 >= inner.box.y1 &&
           inside(outer, (*points_)[inner.begin]);
  };
  if (holes_.empty() || !holds(a, b)) return distance(a, b);
  const Ring* wall = nullptr;
  for (const Ring& hole : holes_)
    if ((wall == nullptr || std::abs(hole.area) > std::abs(wall->area)) && holds(hole, b) && holds(a, hole))
      wall = &hole;
  return wall != nullptr ? distance(*wall, b) : 0.0;
}

/// Least distance between two rings that do not cross: by their hulls where that settles it, else by
/// descending both box trees, nearest boxes first.
double SliceRegions::distance(const Ring& a, const Ring& b) {
  if (const HullDistance::Answer hulls = hulls_.between(a.hull, b.hull); hulls.exact)
    return hulls.distance_mm;
  double best2 = std::numeric_limits<double>::infinity();
  stack_.clear();
  stack_.push_back({gap2(a.box, b.box), 1, 1});
  while (!stack_.empty()) {
    const NodePair pair = stack_.back();
    stack_.pop_back();
    if (pair.gap2 >= best2) continue;
    const bool leaf_a = pair.a >= a.leaves;
    const bool leaf_b = pair.b >= b.leaves;
    if (leaf_a && leaf_b) {
      best2 = leaf_distance2(a, pair.a - a.leaves, b, pair.b - b.leaves, best2);
      continue;
    }
    // Split the ring with more leaves under its node, that is, the node nearer to its root.
    const bool split_a = !leaf_a && (leaf_b || a.leaves / pair.a >= b.leaves / pair.b);
    NodePair one = pair;
    NodePair two = pair;
    (split_a ? one.a : one.b) *= 2;
    (split_a ? two.a : two.b) = 1 + (split_a ? one.a : one.b);
    one.gap2 = gap2(node(a, one.a), node(b, one.b));
    two.gap2 = gap2(node(a, two.a), node(b, two.b));
    if (one.gap2 < two.gap2) std::swap(one, two);
    if (one.gap2 < best2) stack_.push_back(one);
    if (two.gap2 < best2) stack_.push_back(two);
  }
  return std::sqrt(best2);
}

double SliceRegions::leaf_distance2(const Ring& a, std::size_t leaf_a, const Ring& b, std::size_t leaf_b,
                                    double best2) const {
  const std::vector<Point2>& p = *points_;
  auto next = [](const Ring& r, std::size_t i) { return i + 1 == r.end ? r.begin : i + 1; };
  const std::size_t a0 = a.begin + leaf_a * kLeaf;
  const std::size_t b0 = b.begin + leaf_b * kLeaf;
  const std::size_t a1 = std::min(a0 + kLeaf, a.end);
  const std::size_t b1 = std::min(b0 + kLeaf, b.end);
  const Box box_b = node(b, b.leaves + leaf_b);
  auto around = [](Point2 u, Point2 v) {
    return Box{std::min(u.x, v.x), std::min(u.y, v.y), std::max(u.x, v.x), std::max(u.y, v.y)};
  };
  for (std::size_t i = a0; i < a1; ++i) {
    const Point2 i1 = p[next(a, i)];
    const Box box_i = around(p[i], i1);
    if (gap2(box_i, box_b) >= best2) continue;
    for (std::size_t j = b0; j < b1; ++j) {
      const Point2 j1 = p[next(b, j)];
      if (gap2(box_i, around(p[j], j1)) < best2) best2 = std::min(best2, segments2(p[i], i1, p[j], j1));
    }
  }
  return best2;
}

}  // namespace voidpath::orient
