#include "engine/orient/slice_fill.h"

#include "engine/geom/polygon_ops.h"
#include "engine/orient/segment_distance.h"
#include "engine/orient/self_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace voidpath::orient {

namespace {

/// Cracks as wide as this come from rounding to the grid of the polygons. nm
constexpr geom::Coord kCrack = 2;
/// A bundle of contours may fill nothing where their areas sum up to less than this share of them.
constexpr double kNoArea = 1e-6;

/// What a line from p towards -x meets of a contour: how often it enters it, left to right, less how often it
/// leaves it, and where it meets it first.
struct Meeting {
  int winding = 0;
  double nearest_x = -std::numeric_limits<double>::infinity();
};
Meeting look_left(Point2 p, const Contour& c, const std::vector<Point2>& q) {
  Meeting m;
  for (std::size_t i = c.begin, j = c.end - 1; i < c.end; j = i++) {
    const Point2 a = q[j];
    const Point2 b = q[i];
    if ((a.y > p.y) == (b.y > p.y)) continue;
    const double x = a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y);
    if (!(x < p.x)) continue;
    m.winding += b.y < a.y ? 1 : -1;
    m.nearest_x = std::max(m.nearest_x, x);
  }
  return m;
}

void append(const geom::Ring& ring, Index region, bool is_inner, std::vector<Contour>& contours,
            std::vector<Point2>& points) {
  Contour c;
  c.begin = points.size();
  for (const geom::Point& p : ring) points.push_back({geom::to_mm(p.x), geom::to_mm(p.y)});
  c.end = points.size();
  c.area_mm2 = geom::to_mm2(geom::area(ring));
  c.region = region;
  c.is_inner = is_inner;
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
  Index region = 0;
  for (const geom::Region& r : regions) {
    if (geom::to_mm2(geom::area(r.outer)) <= kLeastArea) continue;
    append(r.outer, region, false, contours, points);
    for (const geom::Ring& hole : r.holes) append(hole, region, true, contours, points);
    ++region;
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

/// Whether the lines in which the plane at `level` cuts two facets meet.
bool SliceFill::segments_meet(Index t, Index u, double level) const {
  struct Segment {
    Point2 a, b;
    int ends = 0;
  };
  auto cut = [&](Index facet) {
    Segment s;
    const auto& v = solid_->triangles[facet];
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
  const Segment s = cut(t);
  const Segment r = cut(u);
  if (s.ends != 2 || r.ends != 2) return false;
  const bool cross = (side(s.a, s.b, r.a) > 0) != (side(s.a, s.b, r.b) > 0) &&
                     (side(r.a, r.b, s.a) > 0) != (side(r.a, r.b, s.b) > 0);
  const double touch = touch_mm(*solid_);
  return cross || segments2(s.a, s.b, r.a, r.b) <= touch * touch;
}

Index SliceFill::bundle_of(Index contour) {
  while (joined_[contour] != contour) contour = joined_[contour] = joined_[joined_[contour]];
  return contour;
}

/// Fills bundles_ and bundle_at_ from joined_.
void SliceFill::gather(const std::vector<Contour>& contours, const std::vector<Point2>& points) {
  bundles_.clear();
  bundle_at_.assign(contours.size(), kNone);
  low_high_.resize(contours.size());
  for (Index i = 0; i < contours.size(); ++i) {
    const Contour& c = contours[i];
    if (std::abs(c.area_mm2) <= kLeastArea) continue;
    const Index first = bundle_of(i);
    if (bundle_at_[first] == kNone) {
      bundle_at_[first] = static_cast<Index>(bundles_.size());
      Bundle b;
      b.leftmost = points[c.begin];
      b.on_edge = {0.5 * (points[c.begin].x + points[c.begin + 1].x),
                   0.5 * (points[c.begin].y + points[c.begin + 1].y)};
      bundles_.push_back(b);
    }
    bundle_at_[i] = bundle_at_[first];
    Bundle& b = bundles_[bundle_at_[i]];
    b.area += c.area_mm2;
    b.areas += std::abs(c.area_mm2);
    Point2& range = low_high_[i];
    range = {points[c.begin].y, points[c.begin].y};
    for (std::size_t k = c.begin; k < c.end; ++k) {
      const Point2 q = points[k];
      if (q.x < b.leftmost.x || (q.x == b.leftmost.x && q.y < b.leftmost.y)) b.leftmost = q;
      range.x = std::min(range.x, q.y);
      range.y = std::max(range.y, q.y);
    }
  }
}

/// Finds what each bundle lies within. False where that cannot be told.
bool SliceFill::nest(const std::vector<Contour>& contours, const std::vector<Point2>& points) {
  for (Index i = 0; i < bundles_.size(); ++i) {
    Bundle& b = bundles_[i];
    if (std::abs(b.area) <= kNoArea * b.areas) return false;
    auto each_beside = [&](double y, const auto& visit) {
      for (std::size_t k = 0; k < contours.size(); ++k)
        if (bundle_at_[k] != kNone && bundle_at_[k] != i && low_high_[k].x <= y && low_high_[k].y >= y)
          visit(k);
    };
    // The middle of an edge, which no other bundle touches with a corner.
    int winding = 0;
    each_beside(b.on_edge.y,
                [&](std::size_t k) { winding += look_left(b.on_edge, contours[k], points).winding; });
    if (winding == 0) continue;
    double nearest = -std::numeric_limits<double>::infinity();
    each_beside(b.leftmost.y, [&](std::size_t k) {
      const double x = look_left(b.leftmost, contours[k], points).nearest_x;
      if (x > nearest) {
        nearest = x;
        b.within = bundle_at_[k];
      }
    });
    if (b.within == kNone) return false;
  }
  return true;
}

bool SliceFill::settle(std::size_t i, CrossSections& sections) {
  if (sound_) return false;
  std::vector<Contour>& contours = sections.contours();
  const bool tangled = std::any_of(contours.begin(), contours.end(),
                                   [&](const Contour& c) { return solid_->shell_tangled[c.shell] != 0; });
  auto is_swallowed = [&](const Contour& c) { return solid_->shell_walls[c.shell] == Wall::swallowed; };
  if (!tangled) {
    std::erase_if(contours, is_swallowed);
    return false;
  }
  for (Contour& c : contours)
    if (is_swallowed(c)) c.area_mm2 = 0;  // left out below
  joined_.resize(contours.size());
  std::iota(joined_.begin(), joined_.end(), Index{0});
  for (std::size_t k = first_[i]; k < first_[i + 1]; ++k) {
    const auto& [t, u] = solid_->contacts[near_[k]];
    if (!sections.cuts(t) || !sections.cuts(u)) continue;
    const Index a = bundle_of(sections.contour_of(t));
    const Index b = bundle_of(sections.contour_of(u));
    if (a == b || std::abs(contours[sections.contour_of(t)].area_mm2) <= kLeastArea ||
        std::abs(contours[sections.contour_of(u)].area_mm2) <= kLeastArea)
      continue;
    if (segments_meet(t, u, (*slabs_)[i].middle_mm)) joined_[std::max(a, b)] = std::min(a, b);
  }
  gather(contours, sections.points());
  if (!nest(contours, sections.points())) {
    std::erase_if(contours, [](const Contour& c) { return c.area_mm2 == 0; });
    unite(contours, sections.points(), touch_mm(*solid_));
    return true;
  }
  for (std::size_t k = 0; k < contours.size(); ++k) {
    if (bundle_at_[k] == kNone) continue;
    Index b = bundle_at_[k];
    contours[k].is_inner = bundles_[b].within != kNone;
    while (bundles_[b].within != kNone) b = bundles_[b].within;
    contours[k].region = b;
  }
  std::erase_if(contours, [](const Contour& c) { return c.region == kNone; });
  return true;
}

}  // namespace voidpath::orient
