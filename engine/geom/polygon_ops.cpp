#include "engine/geom/polygon_ops.h"

#include "engine/geom/nesting.h"
#include "engine/geom/offset_ring.h"
#include "engine/geom/predicates.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <polyclipping/clipper.hpp>

namespace voidpath::geom {

namespace {

namespace cl = ClipperLib;

/// How far a round join may stray from its arc, nm: below a printer's finest step.
constexpr double kArcToleranceNm = 5000;
/// Clipper rounds the number of chords in a join, so one may be up to 1.5 times as long as asked for; its
/// sagitta grows with the square of that.
constexpr double kClipperArcSlack = 1.5 * 1.5;
/// Clipper knows no smaller one.
constexpr double kLeastMiterLimit = 2;

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

/// How a region takes part in an operation on two sets.
enum class Part : char {
  apart,   ///< its box meets none of the other set's
  common,  ///< it is in the other set unchanged; whatever else is in either set lies outside of it
  mixed
};

struct Parts {
  std::vector<Part> a;
  std::vector<Part> b;
};

Parts parts_of(const Regions& a, const Regions& b) {
  const std::vector<Box> boxes_a = boxes_of(a);
  const std::vector<Box> boxes_b = boxes_of(b);
  Parts parts{std::vector<Part>(a.size(), Part::apart), std::vector<Part>(b.size(), Part::apart)};
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t k = 0; k < b.size(); ++k) {
      if (!overlap(boxes_a[i], boxes_b[k])) continue;
      if (parts.a[i] != Part::common && parts.b[k] != Part::common)
        parts.a[i] = parts.b[k] = boxes_a[i] == boxes_b[k] && a[i] == b[k] ? Part::common : Part::mixed;
      if (parts.a[i] == Part::apart) parts.a[i] = Part::mixed;
      if (parts.b[k] == Part::apart) parts.b[k] = Part::mixed;
    }
  return parts;
}

/// Only regions that may truly meet go through the clipper; the others are in the result as they are or
/// not at all.
Regions combine(const Regions& a, const Regions& b, cl::ClipType type) {
  const Parts parts = parts_of(a, b);
  Regions out;
  cl::Clipper clipper;
  bool any_a = false;
  bool any_b = false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (parts.a[i] == Part::mixed) {
      add(clipper, a[i], cl::ptSubject);
      any_a = true;
    } else if (type == cl::ctUnion || (type == cl::ctIntersection) == (parts.a[i] == Part::common)) {
      out.push_back(a[i]);
    }
  }
  for (std::size_t i = 0; i < b.size(); ++i) {
    if (parts.b[i] == Part::mixed) {
      add(clipper, b[i], cl::ptClip);
      any_b = true;
    } else if (type == cl::ctUnion && parts.b[i] == Part::apart) {
      out.push_back(b[i]);
    }
  }
  if (!any_a && (!any_b || type != cl::ctUnion)) return out;
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

Regions clipper_offset(const Regions& regions, Coord delta, const OffsetStyle& style) {
  cl::ClipperOffset offsetter(style.miter_limit, style.arc_tolerance_nm / kClipperArcSlack);
  for (const Region& r : regions) {
    offsetter.AddPath(to_clipper(r.outer), join_type(style.join), cl::etClosedPolygon);
    for (const Ring& hole : r.holes)
      offsetter.AddPath(to_clipper(hole), join_type(style.join), cl::etClosedPolygon);
  }
  cl::PolyTree tree;
  offsetter.Execute(tree, static_cast<double>(delta));
  Regions out;
  append_regions(tree, out);
  return out;
}

/// One ring's offset by itself, with the ring's own sense.
void append_clipper_offset(const Ring& ring, Coord delta, const OffsetStyle& style, Rings& out) {
  const bool is_hole = area(ring) < 0;
  Region alone{ring, {}};
  if (is_hole) reverse(alone.outer);
  for (Ring& r : rings_of(clipper_offset({alone}, is_hole ? -delta : delta, style))) {
    if (is_hole) reverse(r);
    out.push_back(std::move(r));
  }
}

/// Offsets every ring by itself. Where no two of the results touch, their winding tells what is filled: a
/// shrunk area is its shrunk outer ring less its grown holes, grown areas unite. Nothing otherwise.
std::optional<Regions> offset_ring_by_ring(const Regions& regions, Coord delta, const OffsetStyle& style) {
  Rings moved;
  Rings hard;
  for (const Region& r : regions) {
    auto take = [&](const Ring& ring) {
      if (std::optional<Ring> m = offset_ring(ring, delta, style))
        moved.push_back(*std::move(m));
      else
        hard.push_back(ring);
    };
    take(r.outer);
    std::for_each(r.holes.begin(), r.holes.end(), take);
  }
  // All hard: ring by ring would only be slower.
  if (moved.empty() || (!hard.empty() && any_edges_touch(moved))) return std::nullopt;
  for (const Ring& ring : hard) append_clipper_offset(ring, delta, style, moved);
  return nest_if_disjoint(moved, FillRule::positive);
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
  if (delta == 0 || regions.empty()) return regions;
  const OffsetStyle style{join, std::max(miter_limit, kLeastMiterLimit), kArcToleranceNm};
  if (std::optional<Regions> direct = offset_ring_by_ring(regions, delta, style)) return *std::move(direct);
  return clipper_offset(regions, delta, style);
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
