#include "engine/toolpath/support/held_pieces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace voidpath::toolpath {

using geom::Point;
using geom::Polyline;

namespace {

/// A loop that hangs somewhere begins and ends so far inside what carries it, mm.
constexpr double kSeamInsetMm = 0.5;

void join(Polyline& to, const Polyline& next) { to.insert(to.end(), next.begin() + 1, next.end()); }

/// A closed line's stretches from a place on its longest held one around to there again: what is cut there
/// has both its ends where they are carried.
std::vector<Stretch> from_held(std::vector<Stretch>&& loop) {
  if (loop.size() > 1 && loop.front().held == loop.back().held) {
    join(loop.back().points, loop.front().points);
    loop.erase(loop.begin());
  }
  const auto rank = [](const Stretch& s) { return s.held ? geom::length(s.points) : -1.0; };
  const auto longest = std::max_element(
      loop.begin(), loop.end(), [&](const Stretch& a, const Stretch& b) { return rank(a) < rank(b); });
  std::rotate(loop.begin(), longest, loop.end());
  Polyline& first = loop.front().points;
  const double before = std::min(kSeamInsetMm * geom::kNmPerMm, 0.5 * geom::length(first));
  std::size_t k = 1;
  double way = geom::distance(first[0], first[1]);
  while (way < before) way += geom::distance(first[k], first[k + 1]), ++k;
  const double over = (way - before) / std::max(geom::distance(first[k - 1], first[k]), 1.0);
  const Point seam{first[k].x - std::llround(over * static_cast<double>(first[k].x - first[k - 1].x)),
                   first[k].y - std::llround(over * static_cast<double>(first[k].y - first[k - 1].y))};
  const auto cut = first.begin() + static_cast<std::ptrdiff_t>(k);
  Stretch last{{first.begin(), cut}, true};
  last.points.push_back(seam);
  *first.erase(first.begin(), cut - 1) = seam;
  loop.push_back(std::move(last));
  return std::move(loop);
}

}  // namespace

geom::Polylines held_pieces(std::vector<Stretch>&& stretches, bool closed, double tip_mm, double span_mm) {
  geom::Polylines out;
  if (std::none_of(stretches.begin(), stretches.end(), [](const Stretch& s) { return s.held; })) return out;
  if (closed) stretches = from_held(std::move(stretches));
  const std::size_t n = stretches.size();
  bool open = false;  // the last piece goes on
  for (std::size_t k = 0; k < n; ++k) {
    Stretch& s = stretches[k];
    const bool end = k == 0 || k + 1 == n;
    const double limit = s.held ? 0 : (end ? tip_mm : span_mm) * geom::kNmPerMm;
    if (!s.held && geom::length(s.points) > limit) {
      open = false;
      continue;
    }
    if (open)
      join(out.back(), s.points);
    else
      out.push_back(std::move(s.points));
    open = true;
  }
  if (closed && out.size() > 1) {
    join(out.back(), out.front());
    out.erase(out.begin());
  }
  return out;
}

}  // namespace voidpath::toolpath
