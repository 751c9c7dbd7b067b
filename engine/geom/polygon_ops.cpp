#include "engine/geom/polygon_ops.h"

#include "engine/geom/offset_ring.h"
#include "engine/geom/overlay.h"
#include "engine/geom/predicates.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
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
/// Corners that are moved and moved back come to lie at most this far beside, nm.
constexpr Coord kDrift = 3;
/// From which the width of a ring is looked at.
constexpr int kDirections = 8;
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

cl::ClipType clip_type(Overlay kind) {
  switch (kind) {
    case Overlay::subtract:
      return cl::ctDifference;
    case Overlay::intersect:
      return cl::ctIntersection;
    case Overlay::unite:
      break;
  }
  return cl::ctUnion;
}

Regions swept(const Rings& a, const Rings& b, Overlay kind) {
  cl::Clipper clipper;
  for (const Ring& ring : a) clipper.AddPath(to_clipper(ring), cl::ptSubject, true);
  for (const Ring& ring : b) clipper.AddPath(to_clipper(ring), cl::ptClip, true);
  cl::PolyTree tree;
  clipper.Execute(clip_type(kind), tree, cl::pftPositive, cl::pftPositive);
  Regions out;
  append_regions(tree, out);
  return out;
}

void append_rings(const Region& region, Rings& out) {
  out.push_back(region.outer);
  out.insert(out.end(), region.holes.begin(), region.holes.end());
}

/// Only regions that may truly meet are laid over one another; the others are in the result as they are or
/// not at all.
Regions combine(const Regions& a, const Regions& b, Overlay kind) {
  const Parts parts = parts_of(a, b);
  Regions out;
  Rings mixed_a, mixed_b;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (parts.a[i] == Part::mixed)
      append_rings(a[i], mixed_a);
    else if (kind == Overlay::unite || (kind == Overlay::intersect) == (parts.a[i] == Part::common))
      out.push_back(a[i]);
  }
  for (std::size_t i = 0; i < b.size(); ++i) {
    if (parts.b[i] == Part::mixed)
      append_rings(b[i], mixed_b);
    else if (kind == Overlay::unite && parts.b[i] == Part::apart)
      out.push_back(b[i]);
  }
  if (mixed_a.empty() && (mixed_b.empty() || kind != Overlay::unite)) return out;
  std::optional<Regions> met = overlay(mixed_a, mixed_b, kind);
  if (!met) met = swept(mixed_a, mixed_b, kind);
  out.insert(out.end(), std::make_move_iterator(met->begin()), std::make_move_iterator(met->end()));
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

/// Whether a ring is so narrow, looked at from one of a few directions, that its edges moved inwards by
/// `reach` leave nothing: all of them would cross one another.
bool vanishes(const Ring& ring, Coord reach) {
  const double least = 2 * static_cast<double>(reach);
  for (int k = 0; k < kDirections; ++k) {
    const double turn = std::numbers::pi * k / kDirections;
    const double x = std::cos(turn), y = std::sin(turn);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Point& p : ring) {
      const double along = x * static_cast<double>(p.x) + y * static_cast<double>(p.y);
      low = std::min(low, along);
      high = std::max(high, along);
    }
    if (high - low < least) return true;
  }
  return false;
}

std::optional<Regions> direct_offset(const Regions& regions, Coord delta, const OffsetStyle& style) {
  Rings moved;
  for (const Region& r : regions) {
    if (delta < 0 && vanishes(r.outer, -delta)) continue;
    moved.push_back(raw_offset_ring(r.outer, delta, style));
    for (const Ring& hole : r.holes)
      if (delta < 0 || !vanishes(hole, delta)) moved.push_back(raw_offset_ring(hole, delta, style));
  }
  return filled(moved, FillRule::positive);
}

/// Corners that went out and came back by rounding a little beside where they were, put back: what an
/// operation leaves alone stays the same.
Regions with_corners_of(const Regions& old, Regions regions) {
  std::vector<Point> corners;
  for (const Region& r : old) {
    corners.insert(corners.end(), r.outer.begin(), r.outer.end());
    for (const Ring& hole : r.holes) corners.insert(corners.end(), hole.begin(), hole.end());
  }
  std::sort(corners.begin(), corners.end());
  auto put_back = [&](Ring& ring) {
    for (Point& p : ring) {
      const Point from{p.x - kDrift, p.y - kDrift};
      for (auto c = std::lower_bound(corners.begin(), corners.end(), from);
           c != corners.end() && c->x <= p.x + kDrift; ++c)
        if (std::abs(c->y - p.y) <= kDrift) {
          p = *c;
          break;
        }
    }
  };
  for (Region& r : regions) {
    put_back(r.outer);
    std::for_each(r.holes.begin(), r.holes.end(), put_back);
  }
  return regions;
}

}  // namespace

Regions unite(const Rings& rings, FillRule rule) {
  if (std::optional<Regions> direct = filled(rings, rule)) return *std::move(direct);
  cl::Clipper clipper;
  for (const Ring& ring : rings) clipper.AddPath(to_clipper(ring), cl::ptSubject, true);
  cl::PolyTree tree;
  clipper.Execute(cl::ctUnion, tree, fill_type(rule), fill_type(rule));
  Regions out;
  append_regions(tree, out);
  return out;
}

Regions unite(const Regions& a, const Regions& b) { return combine(a, b, Overlay::unite); }
Regions subtract(const Regions& from, const Regions& what) { return combine(from, what, Overlay::subtract); }
Regions intersect(const Regions& a, const Regions& b) { return combine(a, b, Overlay::intersect); }

Regions offset(const Regions& regions, Coord delta, Join join, double miter_limit) {
  if (delta == 0 || regions.empty()) return regions;
  const OffsetStyle style{join, std::max(miter_limit, kLeastMiterLimit), kArcToleranceNm};
  if (std::optional<Regions> direct = direct_offset(regions, delta, style)) return *std::move(direct);
  return clipper_offset(regions, delta, style);
}

Regions open(const Regions& regions, Coord radius, Join join) {
  return with_corners_of(regions, offset(offset(regions, -radius, join), radius, join));
}

Regions close(const Regions& regions, Coord radius, Join join) {
  return with_corners_of(regions, offset(offset(regions, radius, join), -radius, join));
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
