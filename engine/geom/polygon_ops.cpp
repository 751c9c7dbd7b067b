#include "engine/geom/polygon_ops.h"

#include "engine/geom/nesting.h"
#include "engine/geom/predicates.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <polyclipping/clipper.hpp>

namespace voidpath::geom {

namespace {

namespace cl = ClipperLib;

/// How far a round join may stray from its arc, nm: below a printer's finest step. Clipper rounds the
/// number of chords in a join, so one may be up to 1.5 times as long as asked for; its sagitta grows
/// with the square of that.
constexpr double kArcToleranceNm = 5000 / (1.5 * 1.5);

cl::Path to_clipper(const Ring& ring) {
  cl::Path path;
  path.reserve(ring.size());
  for (const Point& p : ring) path.emplace_back(p.x, p.y);
  return path;
}

Ring from_clipper(const cl::Path& path) {
  Ring ring;
  ring.reserve(path.size());
  for (const cl::IntPoint& p : path) ring.push_back({p.X, p.Y});
  return ring;
}

/// `node` is an outer ring; its children are holes, theirs are outer rings again. Rounding to whole nm
/// can turn a sliver inside out: such rings hold no area and are left out.
void append_regions(const cl::PolyNode& node, Regions& out) {
  Region region{from_clipper(node.Contour), {}};
  if (area(region.outer) > 0) {
    region.holes.reserve(node.Childs.size());
    for (const cl::PolyNode* child : node.Childs) {
      Ring hole = from_clipper(child->Contour);
      if (area(hole) < 0) region.holes.push_back(std::move(hole));
    }
    out.push_back(std::move(region));
  }
  for (const cl::PolyNode* hole : node.Childs)
    for (const cl::PolyNode* island : hole->Childs) append_regions(*island, out);
}

void append_regions(const cl::PolyTree& tree, Regions& out) {
  for (const cl::PolyNode* node : tree.Childs) append_regions(*node, out);
}

cl::PolyFillType fill_type(FillRule rule) {
  switch (rule) {
    case FillRule::even_odd:
      return cl::pftEvenOdd;
    case FillRule::positive:
      return cl::pftPositive;
    case FillRule::non_zero:
      break;
  }
  return cl::pftNonZero;
}

void add(cl::Clipper& clipper, const Region& region, cl::PolyType type) {
  clipper.AddPath(to_clipper(region.outer), type, true);
  for (const Ring& hole : region.holes) clipper.AddPath(to_clipper(hole), type, true);
}

std::vector<Box> boxes_of(const Regions& regions) {
  std::vector<Box> boxes;
  boxes.reserve(regions.size());
  for (const Region& r : regions) boxes.push_back(bounds(r.outer).value_or(Box{{1, 1}, {0, 0}}));
  return boxes;
}

/// Which of the boxes meet at least one of the others'.
std::vector<char> met(const std::vector<Box>& boxes, const std::vector<Box>& others) {
  std::vector<char> hit(boxes.size(), 0);
  for (std::size_t i = 0; i < boxes.size(); ++i)
    hit[i] = std::any_of(others.begin(), others.end(), [&](const Box& o) { return overlap(boxes[i], o); });
  return hit;
}

/// Only regions whose boxes meet go through the clipper; the others are in the result as they are or not
/// at all.
Regions combine(const Regions& a, const Regions& b, cl::ClipType type) {
  const std::vector<Box> boxes_a = boxes_of(a);
  const std::vector<Box> boxes_b = boxes_of(b);
  const std::vector<char> hit_a = met(boxes_a, boxes_b);
  const std::vector<char> hit_b = met(boxes_b, boxes_a);
  Regions out;
  cl::Clipper clipper;
  bool any = false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (hit_a[i]) {
      add(clipper, a[i], cl::ptSubject);
      any = true;
    } else if (type != cl::ctIntersection) {
      out.push_back(a[i]);
    }
  }
  for (std::size_t i = 0; i < b.size(); ++i) {
    if (hit_b[i]) {
      add(clipper, b[i], cl::ptClip);
    } else if (type == cl::ctUnion) {
      out.push_back(b[i]);
    }
  }
  if (!any) return out;
  cl::PolyTree tree;
  clipper.Execute(type, tree, cl::pftPositive, cl::pftPositive);
  append_regions(tree, out);
  return out;
}

cl::JoinType join_type(Join join) {
  switch (join) {
    case Join::round:
      return cl::jtRound;
    case Join::square:
      return cl::jtSquare;
    case Join::miter:
      break;
  }
  return cl::jtMiter;
}

}  // namespace

Regions unite(const Rings& rings, FillRule rule) {
  if (std::optional<Regions> nested = nest_if_disjoint(rings, rule)) return *std::move(nested);
  cl::Clipper clipper;
  for (const Ring& ring : rings) clipper.AddPath(to_clipper(ring), cl::ptSubject, true);
  cl::PolyTree tree;
  clipper.Execute(cl::ctUnion, tree, fill_type(rule), fill_type(rule));
  Regions out;
  append_regions(tree, out);
  return out;
}

Regions unite(const Regions& a, const Regions& b) { return combine(a, b, cl::ctUnion); }
Regions subtract(const Regions& from, const Regions& what) { return combine(from, what, cl::ctDifference); }
Regions intersect(const Regions& a, const Regions& b) { return combine(a, b, cl::ctIntersection); }

Regions offset(const Regions& regions, Coord delta, Join join, double miter_limit) {
  if (delta == 0) return regions;
  cl::ClipperOffset offsetter(miter_limit, kArcToleranceNm);
  for (const Region& r : regions) {
    offsetter.AddPath(to_clipper(r.outer), join_type(join), cl::etClosedPolygon);
    for (const Ring& hole : r.holes)
      offsetter.AddPath(to_clipper(hole), join_type(join), cl::etClosedPolygon);
  }
  cl::PolyTree tree;
  offsetter.Execute(tree, static_cast<double>(delta));
  Regions out;
  append_regions(tree, out);
  return out;
}

Regions open(const Regions& regions, Coord radius, Join join) {
  return offset(offset(regions, -radius, join), radius, join);
}

Regions close(const Regions& regions, Coord radius, Join join) {
  return offset(offset(regions, radius, join), -radius, join);
}

Regions remove_small(const Regions& regions, double min_area_nm2) {
  Regions out;
  for (const Region& r : regions) {
    if (area(r) < min_area_nm2) continue;
    Region kept{r.outer, {}};
    for (const Ring& hole : r.holes)
      if (-area(hole) >= min_area_nm2) kept.holes.push_back(hole);
    out.push_back(std::move(kept));
  }
  return out;
}

Ring make_rectangle(Point min, Point max) { return {min, {max.x, min.y}, max, {min.x, max.y}}; }

Ring make_circle(Point centre, Coord radius, int sides) {
  Ring ring;
  ring.reserve(static_cast<std::size_t>(std::max(sides, 0)));
  for (int i = 0; i < sides; ++i) {
    const double a = 2 * std::numbers::pi * i / sides;
    const auto r = static_cast<double>(radius);
    ring.push_back({centre.x + std::llround(r * std::cos(a)), centre.y + std::llround(r * std::sin(a))});
  }
  return ring;
}

}  // namespace voidpath::geom
