#include "engine/toolpath/walls/border.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voidpath::toolpath {

namespace {

/// Fewer edges than this are looked at one by one: quicker than to sort them.
constexpr std::size_t kManyEdges = 64;
/// Cells of the index are no smaller than this, mm: about what is asked for.
constexpr double kLeastCellMm = 0.3;

}  // namespace

Border::Border(const geom::Regions& areas) : edges_(geom::edges_of(geom::rings_of(areas))) {
  if (edges_.size() < kManyEdges) return;
  const geom::Box box = *geom::bounds(areas);
  const double size =
      std::sqrt(static_cast<double>(box.max.x - box.min.x) * static_cast<double>(box.max.y - box.min.y) /
                static_cast<double>(edges_.size()));
  index_.emplace(box, std::max(geom::from_mm(kLeastCellMm), static_cast<geom::Coord>(size)));
  for (const geom::Edge& e : edges_) index_->add(e.a, e.b);
}

double Border::distance_mm(const geom::Point& p, double limit_mm) const {
  if (index_) return index_->nearest(p, limit_mm * geom::kNmPerMm).distance / geom::kNmPerMm;
  double best = std::numeric_limits<double>::max();
  for (const geom::Edge& e : edges_) best = std::min(best, geom::distance(p, nearest_on_line(p, e.a, e.b)));
  return best / geom::kNmPerMm;
}

geom::Point Border::nearest(const geom::Point& p, double limit_mm) const {
  double best = limit_mm * geom::kNmPerMm;
  geom::Point out = p;
  if (index_) {
    const LineIndex::Hit hit = index_->nearest(p, best);
    return hit.distance <= best ? hit.at : out;
  }
  for (const geom::Edge& e : edges_) {
    const geom::Point q = nearest_on_line(p, e.a, e.b);
    const double d = geom::distance(p, q);
    if (d <= best) best = d, out = q;
  }
  return out;
}

}  // namespace voidpath::toolpath
