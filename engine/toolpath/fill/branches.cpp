#include "engine/toolpath/fill/branches.h"

#include <algorithm>
#include <cmath>

namespace voidpath::toolpath {

namespace {

using geom::Point;

/// Roots stay this far inside the border, nm, so that rounding does not cut them off.
constexpr double kInsideNm = 5000;
/// Nodes nearer to a line's end than this join it, nm.
constexpr double kSameNm = 20000;

/// Further than any way on a bed, nm.
constexpr double kAnywhereNm = 1e12;
/// Share of a branch's way to its root that counts for who joins it.
constexpr double kWayShare = 0.5;

Point towards(const Point& from, const Point& to, double by) {
  const double d = geom::distance(from, to);
  if (d <= by) return to;
  const double t = by / d;
  return {from.x + std::llround(t * static_cast<double>(to.x - from.x)),
          from.y + std::llround(t * static_cast<double>(to.y - from.y))};
}

}  // namespace

std::vector<std::vector<std::uint32_t>> Branches::children() const {
  std::vector<std::vector<std::uint32_t>> out(nodes_.size());
  for (std::uint32_t i = 0; i < nodes_.size(); ++i)
    if (nodes_[i].parent != kNone) out[nodes_[i].parent].push_back(i);
  return out;
}

void Branches::sort() {
  const auto kids = children();
  std::vector<Node> sorted;
  sorted.reserve(nodes_.size());
  std::vector<std::uint32_t> place(nodes_.size());
  std::vector<std::uint32_t> open;
  for (std::uint32_t r = 0; r < nodes_.size(); ++r) {
    if (nodes_[r].parent != kNone) continue;
    open.push_back(r);
    while (!open.empty()) {
      const std::uint32_t n = open.back();
      open.pop_back();
      place[n] = static_cast<std::uint32_t>(sorted.size());
      sorted.push_back({nodes_[n].at, nodes_[n].parent == kNone ? kNone : place[nodes_[n].parent]});
      open.insert(open.end(), kids[n].rbegin(), kids[n].rend());
    }
  }
  nodes_ = std::move(sorted);
}

void Branches::shrink(double by) {
  const auto kids = children();
  std::vector<Node> out;
  std::vector<std::uint32_t> place(nodes_.size(), kNone);
  // How far the tips that remain are shortened at each node, from the tips down.
  std::vector<double> left(nodes_.size(), 0);
  std::vector<char> gone(nodes_.size(), 0);
  for (std::uint32_t n = static_cast<std::uint32_t>(nodes_.size()); n-- > 0;) {
    double need = by;  // of the branch that lives longest
    for (const std::uint32_t k : kids[n]) need = std::min(need, gone[k] ? left[k] : 0.0);
    left[n] = need;
    if (nodes_[n].parent == kNone) {
      gone[n] = need > 0;
      continue;
    }
    const double step = geom::distance(nodes_[n].at, nodes_[nodes_[n].parent].at);
    gone[n] = need >= step;
    if (gone[n]) left[n] = need - step;
  }
  for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
    if (gone[n]) continue;
    const std::uint32_t parent = nodes_[n].parent;
    Point at = nodes_[n].at;
    if (parent != kNone) {
      if (left[n] > 0) at = towards(at, nodes_[parent].at, left[n]);
      std::uint32_t only = kNone;
      std::size_t alive = 0;
      for (const std::uint32_t k : kids[n])
        if (!gone[k]) only = k, ++alive;
      if (alive == 1) at = towards(at, nearest_on_line(at, nodes_[parent].at, nodes_[only].at), by);
    }
    place[n] = static_cast<std::uint32_t>(out.size());
    out.push_back({at, parent == kNone ? kNone : place[parent]});
  }
  nodes_ = std::move(out);
}

void Branches::clip(const geom::AreaGrid& area) {
  std::vector<Node> out;
  std::vector<std::uint32_t> place(nodes_.size(), kNone);
  auto put = [&](const Point& at, std::uint32_t parent) {
    out.push_back({at, parent});
    return static_cast<std::uint32_t>(out.size() - 1);
  };
  for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
    const Point& at = nodes_[n].at;
    const bool inside = area.contains(at);
    if (nodes_[n].parent == kNone) {
      if (inside) place[n] = put(at, kNone);
      continue;
    }
    const std::uint32_t parent = nodes_[n].parent;
    const Point& from = nodes_[parent].at;
    if (inside && place[parent] != kNone && area.contains(from, at)) {
      place[n] = put(at, place[parent]);
      continue;
    }
    const std::vector<geom::Piece> pieces = area.split({from, at});
    if (pieces.empty()) continue;
    // The first piece keeps its root, the last one gets a new root where it comes in.
    if (place[parent] != kNone && pieces.front().inside)
      put(towards(pieces.front().points.back(), from, kInsideNm), place[parent]);
    if (inside && pieces.back().inside) {
      const std::uint32_t root = put(towards(pieces.back().points.front(), at, kInsideNm), kNone);
      place[n] = put(at, root);
    }
  }
  nodes_ = std::move(out);
}

void Branches::ground(const LineIndex& border, double near) {
  const std::size_t n = nodes_.size();
  for (std::uint32_t i = 0; i < n; ++i) {
    if (nodes_[i].parent != kNone) continue;
    const LineIndex::Hit hit = border.nearest(nodes_[i].at, kAnywhereNm);
    const Point at = towards(hit.at, nodes_[i].at, kInsideNm);
    if (hit.distance <= near) {
      nodes_[i].at = at;
    } else {
      nodes_.push_back({at, kNone});
      nodes_[i].parent = static_cast<std::uint32_t>(nodes_.size() - 1);
    }
  }
}

void Branches::index(LineIndex& lines, std::vector<std::uint32_t>& line_nodes) const {
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].parent == kNone) continue;
    lines.add(nodes_[nodes_[i].parent].at, nodes_[i].at);
    line_nodes.push_back(i);
  }
}

void Branches::connect(const Point& tip, const LineIndex& border, LineIndex& lines,
                       std::vector<std::uint32_t>& line_nodes) {
  const LineIndex::Hit wall = border.nearest(tip, kAnywhereNm);
  std::uint32_t foot = kNone;
  if (const LineIndex::Hit hit = lines.nearest(tip, wall.distance); hit.distance <= wall.distance) {
    std::uint32_t child = line_nodes[hit.line];
    // A line that was cut before is still indexed as a whole: the cut above the point is its lower end now.
    while (geom::distance(nodes_[child].at, hit.at) >
           geom::distance(nodes_[child].at, nodes_[nodes_[child].parent].at) + kSameNm)
      child = nodes_[child].parent;
    const std::uint32_t parent = nodes_[child].parent;
    double way = geom::distance(hit.at, nodes_[parent].at);
    for (std::uint32_t n = parent; nodes_[n].parent != kNone; n = nodes_[n].parent)
      way += geom::distance(nodes_[n].at, nodes_[nodes_[n].parent].at);
    if (hit.distance + kWayShare * way < wall.distance) {
      if (geom::distance(hit.at, nodes_[child].at) <= kSameNm) {
        foot = child;
      } else if (geom::distance(hit.at, nodes_[parent].at) <= kSameNm) {
        foot = parent;
      } else {
        nodes_.push_back({hit.at, parent});
        foot = static_cast<std::uint32_t>(nodes_.size() - 1);
        nodes_[child].parent = foot;
      }
    }
  }
  if (foot == kNone) {
    nodes_.push_back({towards(wall.at, tip, kInsideNm), kNone});
    foot = static_cast<std::uint32_t>(nodes_.size() - 1);
  }
  nodes_.push_back({tip, foot});
  lines.add(nodes_[foot].at, tip);
  line_nodes.push_back(static_cast<std::uint32_t>(nodes_.size() - 1));
}

geom::Polylines Branches::lines() const {
  geom::Polylines out;
  const auto kids = children();
  // Each line goes on along one branch; the others begin lines of their own at the fork.
  auto follow = [&](std::uint32_t from, std::uint32_t to, auto&& again) -> void {
    geom::Polyline line{nodes_[from].at};
    std::vector<std::pair<std::uint32_t, std::uint32_t>> forks;
    for (std::uint32_t n = to;;) {
      line.push_back(nodes_[n].at);
      for (std::size_t k = 1; k < kids[n].size(); ++k) forks.emplace_back(n, kids[n][k]);
      if (kids[n].empty()) break;
      n = kids[n].front();
    }
    out.push_back(std::move(line));
    for (const auto& [a, b] : forks) again(a, b, again);
  };
  for (std::uint32_t i = 0; i < nodes_.size(); ++i)
    if (nodes_[i].parent == kNone)
      for (const std::uint32_t k : kids[i]) follow(i, k, follow);
  return out;
}

}  // namespace voidpath::toolpath
