#include "engine/orient/slice_fill.h"

#include "engine/geom/polygon_ops.h"
#include "engine/orient/self_contact.h"

#include <algorithm>
#include <cmath>

namespace voidpath::orient {

namespace {

/// Cracks as wide as this come from rounding to the grid of the polygons. nm
constexpr geom::Coord kCrack = 2;

int winding_about(Point2 p, const Contour& c, const std::vector<Point2>& q) {
  int w = 0;
  for (std::size_t i = c.begin, j = c.end - 1; i < c.end; j = i++) {
    const Point2 a = q[j];
    const Point2 b = q[i];
    if ((a.y > p.y) == (b.y > p.y)) continue;
    const double side = (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
    if (b.y > a.y && side > 0) ++w;
    if (b.y < a.y && side < 0) --w;
  }
  return w;
}

/// Contours that cross no other: each borders what is filled only if the winding number is nil on one side.
void settle_nested(std::vector<Contour>& contours, const std::vector<Point2>& points) {
  std::vector<Contour> kept;
  for (std::size_t i = 0; i < contours.size(); ++i) {
    Contour c = contours[i];
    // The middle of an edge, which no other contour touches with a corner.
    const Point2 a = points[c.begin];
    const Point2 b = points[c.begin + 1 < c.end ? c.begin + 1 : c.begin];
    const Point2 p{0.5 * (a.x + b.x), 0.5 * (a.y + b.y)};
    int outside = 0;
    for (std::size_t j = 0; j < contours.size(); ++j)
      if (j != i) outside += winding_about(p, contours[j], points);
    const int inside = outside + (c.area_mm2 > 0 ? 1 : -1);
    if ((outside != 0) == (inside != 0)) continue;
    c.area_mm2 = inside != 0 ? std::abs(c.area_mm2) : -std::abs(c.area_mm2);
    kept.push_back(c);
  }
  contours = std::move(kept);
}

void append(const geom::Ring& ring, std::vector<Contour>& contours, std::vector<Point2>& points) {
  Contour c;
  c.begin = points.size();
  for (const geom::Point& p : ring) points.push_back({geom::to_mm(p.x), geom::to_mm(p.y)});
  c.end = points.size();
  c.area_mm2 = geom::to_mm2(geom::area(ring));
  contours.push_back(c);
}

void unite(std::vector<Contour>& contours, std::vector<Point2>& points, double touch) {
  geom::Rings rings;
  for (const Contour& c : contours) {
    geom::Ring ring;
    for (std::size_t k = c.begin; k < c.end; ++k)
      ring.push_back({geom::from_mm(points[k].x), geom::from_mm(points[k].y)});
    rings.push_back(std::move(ring));
  }
  geom::Regions regions = geom::unite(rings);
  // Bodies that lie on one another are one region, also where rounding left a crack between them.
  if (regions.size() > 1) regions = geom::close(regions, std::max<geom::Coord>(kCrack, geom::from_mm(touch)));
  contours.clear();
  points.clear();
  for (const geom::Region& r : regions) {
    append(r.outer, contours, points);
    for (const geom::Ring& hole : r.holes) append(hole, contours, points);
  }
}

}  // namespace

void SliceFill::prepare(const Solid& solid, const Projection& p, const std::vector<Slab>& slabs) {
  solid_ = &solid;
  sound_ = solid.contacts.empty() && std::none_of(solid.shell_walls.begin(), solid.shell_walls.end(),
                                                  [](Wall w) { return w == Wall::swallowed; });
  crossed_.assign(slabs.size(), 0);
  const double touch = touch_mm(solid);
  auto span = [&](Index t) {
    const auto& [a, b, c] = solid.triangles[t];
    return std::minmax({p.h[a], p.h[b], p.h[c]});
  };
  for (const auto& [t, u] : solid.contacts) {
    const auto [t0, t1] = span(t);
    const auto [u0, u1] = span(u);
    const double low = std::max(t0, u0) - touch;
    const double high = std::min(t1, u1) + touch;
    auto i = std::lower_bound(slabs.begin(), slabs.end(), low,
                              [](const Slab& s, double h) { return s.middle_mm < h; });
    for (; i != slabs.end() && i->middle_mm <= high; ++i)
      crossed_[static_cast<std::size_t>(i - slabs.begin())] = 1;
  }
}

void SliceFill::settle(std::size_t i, std::vector<Contour>& contours, std::vector<Point2>& points) const {
  if (sound_) return;
  std::erase_if(contours, [&](const Contour& c) {
    return solid_->shell_walls[c.shell] == Wall::swallowed || std::abs(c.area_mm2) == 0;
  });
  const bool tangled = std::any_of(contours.begin(), contours.end(),
                                   [&](const Contour& c) { return solid_->shell_tangled[c.shell] != 0; });
  if (crossed_[i] != 0) {
    unite(contours, points, touch_mm(*solid_));
  } else if (tangled) {
    settle_nested(contours, points);
  }
}

}  // namespace voidpath::orient
