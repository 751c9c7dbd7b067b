#include "engine/toolpath/order.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voidpath::toolpath {

namespace {

using geom::Point;

/// Effort: improvements look this far along the sequence and go over it this often.
constexpr std::size_t kWindow = 60;
constexpr int kPasses = 4;
/// Runs of up to this many visits are tried in other places.
constexpr std::size_t kMaxMoved = 3;
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

/// Takes short runs of visits out and puts them where they cost less, turned round if that is better
/// (Or-opt).
bool relocate(const std::vector<Stop>& stops, const Point& from, std::vector<Visit>& seq) {
  bool better = false;
  const std::size_t n = seq.size();
  /// Way from visit i to visit j of the sequence; i = -1 is the start, beyond the end there is none.
  auto way = [&](std::size_t i, std::size_t j) {
    if (j >= n) return 0.0;
    return geom::distance(i + 1 == 0 ? from : leave(stops, seq[i]), entry(stops, seq[j]));
  };
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t length = 1; length <= kMaxMoved && i + length <= n; ++length) {
      const std::size_t j = i + length - 1;
      const double saved = way(i - 1, i) + way(j, j + 1) - way(i - 1, j + 1);
      if (saved < kMinGain) continue;
      const bool turnable = std::all_of(seq.begin() + static_cast<std::ptrdiff_t>(i),
                                        seq.begin() + static_cast<std::ptrdiff_t>(j) + 1,
                                        [&](const Visit& v) { return stops[v.index].reversible; });
      const Point &first = entry(stops, seq[i]), &last = leave(stops, seq[j]);
      double best = saved - kMinGain;
      std::size_t place = n;  // after this visit
      bool turned = false;
      const std::size_t low = i > kWindow ? i - kWindow : 0;
      for (std::size_t k = low; k <= std::min(j + kWindow, n); ++k) {  // between k - 1 and k
        if (k >= i && k <= j + 1) continue;
        const Point& before = k == 0 ? from : leave(stops, seq[k - 1]);
        const double old = way(k - 1, k);
        const double ahead = k < n ? geom::distance(last, entry(stops, seq[k])) : 0;
        const double behind = k < n ? geom::distance(first, entry(stops, seq[k])) : 0;
        const double cost = geom::distance(before, first) + ahead - old;
        if (cost < best) best = cost, place = k, turned = false;
        const double cost_turned = geom::distance(before, last) + behind - old;
        if (turnable && cost_turned < best) best = cost_turned, place = k, turned = true;
      }
      if (best >= saved - kMinGain) continue;
      const auto begin = seq.begin() + static_cast<std::ptrdiff_t>(i);
      const auto end = begin + static_cast<std::ptrdiff_t>(length);
      if (turned) {
        std::reverse(begin, end);
        for (auto v = begin; v != end; ++v) v->reversed = !v->reversed;
      }
      const auto to = seq.begin() + static_cast<std::ptrdiff_t>(place);
      if (place < i)
        std::rotate(to, begin, end);
      else
        std::rotate(begin, end, to);
      better = true;
      break;
    }
  return better;
}

}  // namespace

std::vector<Visit> order_stops(const std::vector<Stop>& stops, const Point& from) {
  std::vector<Visit> seq = nearest_neighbour(stops, from);
  for (int pass = 0; pass < kPasses; ++pass) {
    const bool turned = improve(stops, from, seq);
    const bool moved = relocate(stops, from, seq);
    if (!turned && !moved) break;
  }
  return seq;
}

}  // namespace voidpath::toolpath
