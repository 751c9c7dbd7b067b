#include "engine/toolpath/order.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voidpath::toolpath {

namespace {

using geom::Point;

/// Effort: 2-opt looks this far along the sequence and goes over it this often.
constexpr std::size_t kWindow = 60;
constexpr int kPasses = 4;
/// Gains below this are not worth a change, nm.
constexpr double kMinGain = 1000;

const Point& entry(const std::vector<Stop>& stops, const Visit& v) {
  return v.reversed ? stops[v.index].out : stops[v.index].in;
}
const Point& leave(const std::vector<Stop>& stops, const Visit& v) {
  return v.reversed ? stops[v.index].in : stops[v.index].out;
}

double squared(const Point& a, const Point& b) {
  const auto dx = static_cast<double>(a.x - b.x);
  const auto dy = static_cast<double>(a.y - b.y);
  return dx * dx + dy * dy;
}

std::vector<Visit> nearest_neighbour(const std::vector<Stop>& stops, Point at) {
  std::vector<Visit> out;
  out.reserve(stops.size());
  std::vector<std::size_t> left(stops.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
  while (!left.empty()) {
    double best = std::numeric_limits<double>::max();
    std::size_t pick = 0;
    bool reversed = false;
    for (std::size_t k = 0; k < left.size(); ++k) {
      const Stop& s = stops[left[k]];
      const double d = squared(at, s.in);
      if (d < best) best = d, pick = k, reversed = false;
      if (!s.reversible) continue;
      const double r = squared(at, s.out);
      if (r < best) best = r, pick = k, reversed = true;
    }
    out.push_back({left[pick], reversed});
    at = leave(stops, out.back());
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(pick));
  }
  return out;
}

/// Turns visits [i, j] round: the travel into the first and out of the last changes, the rest stays as
/// long as it was.
bool improve(const std::vector<Stop>& stops, const Point& from, std::vector<Visit>& seq) {
  bool better = false;
  for (std::size_t i = 0; i < seq.size(); ++i) {
    const Point& before = i == 0 ? from : leave(stops, seq[i - 1]);
    for (std::size_t j = i; j < std::min(i + kWindow, seq.size()); ++j) {
      const Visit& last = seq[j];
      if (!stops[last.index].reversible) break;
      double gain = geom::distance(before, entry(stops, seq[i])) - geom::distance(before, leave(stops, last));
      if (j + 1 < seq.size()) {
        const Point& after = entry(stops, seq[j + 1]);
        gain += geom::distance(leave(stops, last), after) - geom::distance(entry(stops, seq[i]), after);
      }
      if (gain < kMinGain) continue;
      std::reverse(seq.begin() + static_cast<std::ptrdiff_t>(i),
                   seq.begin() + static_cast<std::ptrdiff_t>(j) + 1);
      for (std::size_t k = i; k <= j; ++k) seq[k].reversed = !seq[k].reversed;
      better = true;
    }
  }
  return better;
}

}  // namespace

std::vector<Visit> order_stops(const std::vector<Stop>& stops, const Point& from) {
  std::vector<Visit> seq = nearest_neighbour(stops, from);
  for (int pass = 0; pass < kPasses && improve(stops, from, seq); ++pass) {
  }
  return seq;
}

}  // namespace voidpath::toolpath
