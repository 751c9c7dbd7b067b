#include "engine/geom/nesting.h"

#include "engine/geom/predicates.h"

#include <utility>

namespace voidpath::geom {

std::optional<Regions> nest(std::vector<TracedRing>&& rings) {
  Regions out;
  std::vector<std::pair<Box, double>> outer;
  std::vector<TracedRing*> holes;
  for (TracedRing& t : rings) {
    const double size = area(t.ring);
    if (size < 0) {
      holes.push_back(&t);
    } else if (size > 0) {
      outer.emplace_back(*bounds(t.ring), size);
      out.push_back({std::move(t.ring), {}});
    }
  }
  for (TracedRing* hole : holes) {
    if (!hole->has_probe) return std::nullopt;
    std::size_t best = out.size();
    for (std::size_t k = 0; k < out.size(); ++k) {
      if (!overlap(outer[k].first, {hole->probe, hole->probe}) ||
          (best < out.size() && outer[best].second <= outer[k].second))
        continue;
      if (contains(out[k].outer, hole->probe)) best = k;
    }
    if (best == out.size()) return std::nullopt;
    out[best].holes.push_back(std::move(hole->ring));
  }
  return out;
}

void drop_straight(Ring& ring) {
  const std::size_t n = ring.size();
  Ring out;
  out.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Point& before = out.empty() ? ring[n - 1] : out.back();
    if (orientation(before, ring[i], ring[(i + 1) % n]) != 0) out.push_back(ring[i]);
  }
  ring = std::move(out);
}

}  // namespace voidpath::geom
