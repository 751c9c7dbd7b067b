#include "engine/orient/slice_fill.h"

#include "engine/geom/polygon_ops.h"
#include "engine/orient/segment_distance.h"
#include "engine/orient/self_contact.h"

#include <algorithm>
#include <cmath>
#include <numeric>

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
  p_ = &p;
  slabs_ = &slabs;
  sound_ = solid.contacts.empty() && std::none_of(solid.shell_walls.begin(), solid.shell_walls.end(),
                                                  [](Wall w) { return w == Wall::swallowed; });
  first_.assign(slabs.size() + 1, 0);
  near_.clear();
  if (sound_) return;
  const double touch = touch_mm(solid);
  auto span = [&](Index t) {
    const auto& [a, b, c] = solid.triangles[t];
    return std::minmax({p.h[a], p.h[b], p.h[c]});
  };
  auto each_slice = [&](Index contact, const auto& visit) {
    const auto [t0, t1] = span(solid.contacts[contact].first);
    const auto [u0, u1] = span(solid.contacts[contact].second);
    const double low = std::max(t0, u0) - touch;
    const double high = std::min(t1, u1) + touch;
    auto i = std::lower_bound(slabs.begin(), slabs.end(), low,
                              [](const Slab& s, double h) { return s.middle_mm < h; });
    for (; i != slabs.end() && i->middle_mm <= high; ++i) visit(static_cast<std::size_t>(i - slabs.begin()));
  };
  const auto contacts = static_cast<Index>(solid.contacts.size());
  for (Index k = 0; k < contacts; ++k) each_slice(k, [&](std::size_t i) { ++first_[i + 1]; });
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  near_.resize(first_.back());
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (Index k = 0; k < contacts; ++k) each_slice(k, [&](std::size_t i) { near_[next[i]++] = k; });
}

/// Whether in slice i the lines of any two facets that meet somewhere meet here.
bool SliceFill::contours_cross(std::size_t i) const {
  const double level = (*slabs_)[i].middle_mm;
  const double touch = touch_mm(*solid_);
  struct Segment {
    Point2 a, b;
    int ends = 0;
  };
  auto cut = [&](Index t) {
    Segment s;
    const auto& v = solid_->triangles[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = v[k];
      const Index b = v[(k + 1) % 3];
      const bool up_a = p_->h[a] + kHeightNoise >= level;
      if (up_a == (p_->h[b] + kHeightNoise >= level)) continue;
      const double r = std::clamp((level - p_->h[a]) / (p_->h[b] - p_->h[a]), 0.0, 1.0);
      const Point2 q{p_->x[a] + r * (p_->x[b] - p_->x[a]), p_->y[a] + r * (p_->y[b] - p_->y[a])};
      (s.ends++ == 0 ? s.a : s.b) = q;
    }
    return s;
  };
  auto side = [](Point2 o, Point2 a, Point2 b) {
    return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
  };
  for (std::size_t k = first_[i]; k < first_[i + 1]; ++k) {
    const Segment s = cut(solid_->contacts[near_[k]].first);
    const Segment t = cut(solid_->contacts[near_[k]].second);
    if (s.ends != 2 || t.ends != 2) continue;
    const bool cross = (side(s.a, s.b, t.a) > 0) != (side(s.a, s.b, t.b) > 0) &&
                       (side(t.a, t.b, s.a) > 0) != (side(t.a, t.b, s.b) > 0);
    if (cross || segments2(s.a, s.b, t.a, t.b) <= touch * touch) return true;
  }
  return false;
}

void SliceFill::settle(std::size_t i, std::vector<Contour>& contours, std::vector<Point2>& points) const {
  if (sound_) return;
  std::erase_if(contours, [&](const Contour& c) {
    return solid_->shell_walls[c.shell] == Wall::swallowed || std::abs(c.area_mm2) == 0;
  });
  const bool tangled = std::any_of(contours.begin(), contours.end(),
                                   [&](const Contour& c) { return solid_->shell_tangled[c.shell] != 0; });
  if (contours_cross(i)) {
    unite(contours, points, touch_mm(*solid_));
  } else if (tangled) {
    settle_nested(contours, points);
  }
}

}  // namespace voidpath::orient
