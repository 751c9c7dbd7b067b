#include "engine/toolpath/support/tree_grow.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Point;
using geom::Regions;

/// A branch's radius grows by this on each mm of its way down.
constexpr double kTaper = 0.06;
/// A branch that carries n tips has at least the square root of n times this share of a tip's radius.
constexpr double kCarryShare = 0.6;
/// On the plate a branch's foot widens by a mm each mm, from this height on, mm.
constexpr double kFootMm = 1.2;
/// Upwards a branch may widen by this share of its way, beside its lean.
constexpr double kWidening = 0.3;
/// Branches seek one another only within this distance, mm.
constexpr double kSeekMm = 25.0;
/// They must be able to meet on this share of their way down.
constexpr double kMeetShare = 0.8;
/// Tips are placed no nearer to another branch than this share of their distance: it holds what is there.
constexpr double kCrowded = 0.7;
/// No place is to be further from a tip than this share of their distance.
constexpr double kReach = 0.65;
/// That is looked at in places this far apart, as a share of the tips' distance.
constexpr double kSampleShare = 0.2;
/// A branch at the edge of its room may have to move this many steps: corners of what is shrunk by a step are
/// cut off.
constexpr double kMaxEscape = 2.2;
/// A tip may be moved by this many of its radii to find room.
constexpr double kTipSlack = 2.0;
/// Leftovers of an area smaller than this need no hold, mm²: their neighbours have it.
constexpr double kMinUnheldMm2 = 2.0;
constexpr double kNm = geom::kNmPerMm;

struct Node {
  Point at;
  double depth_mm = 0;  ///< below the tip
  int tips = 1;
  bool plate = true;
  std::vector<std::size_t> above;  ///< its sections in the layer above: more than one where branches met
};

Point moved(const Point& p, double dx, double dy) { return {p.x + std::llround(dx), p.y + std::llround(dy)}; }

/// From p towards q by `way`, at most to q.
Point towards(const Point& p, const Point& q, double way) {
  const double d = geom::distance(p, q);
  if (d <= way) return q;
  return moved(p, static_cast<double>(q.x - p.x) / d * way, static_cast<double>(q.y - p.y) / d * way);
}

/// Points of the area on a lattice this far apart, nm, and along its border.
std::vector<Point> samples(const geom::Region& region, double apart) {
  std::vector<Point> out;
  const auto box = geom::bounds(region.outer);
  const geom::AreaGrid grid({region});
  const auto step = std::max<geom::Coord>(std::llround(apart), 1);
  const auto first = [&](geom::Coord c) { return (c >= 0 ? c / step : -((step - 1 - c) / step)) * step; };
  for (geom::Coord y = first(box->min.y); y <= box->max.y; y += step)
    for (geom::Coord x = first(box->min.x); x <= box->max.x; x += step)
      if (grid.contains({x, y})) out.push_back({x, y});
  for (const auto& ring : geom::rings_of({region}))
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const Point &a = ring[k], &b = ring[(k + 1) % ring.size()];
      const double length = geom::distance(a, b);
      for (double along = 0; along < length; along += apart) out.push_back(towards(a, b, along));
    }
  return out;
}

class Grower {
 public:
  Grower(const std::vector<Regions>& held, const slice::LayerStack& stack, const TreeRoom& room,
         const SliceSettings& settings, const run::Context& ctx)
      : held_(held), stack_(stack), room_(room), s_(settings), ctx_(ctx) {
    tip_mm_ = 0.5 * s_.tree_tip_diameter_mm;
    lean_ = std::tan(std::clamp(s_.tree_branch_angle_deg, 1.0, 80.0) * std::numbers::pi / 180);
    out_.sections.resize(held.size());
    out_.unheld.resize(held.size());
  }

  Branches run() {
    for (std::size_t i = held_.size(); i-- > 0;) {
      ctx_.check();
      if (!held_[i].empty()) place_tips(i);
      record(i);
      if (i > 0) descend(i);
    }
    narrow();
    return std::move(out_);
  }

 private:
  /// Above a place where it had to be thin, a branch grows thick again no faster than it can be printed.
  void narrow() {
    for (std::size_t i = 1; i < out_.sections.size(); ++i)
      for (BranchSection& section : out_.sections[i]) {
        if (!section.below) continue;
        const double below = out_.sections[i - 1][*section.below].radius_mm;
        section.radius_mm = std::min(section.radius_mm, below + kWidening * stack_[i].span.height_mm());
      }
  }

  /// Where a branch may begin, at or near the place wanted.
  std::optional<Node> tip_at(std::size_t i, const Point& wanted) const {
    const double slack = kTipSlack * tip_mm_ * kNm;
    if (const auto place = room_.nearest(i, wanted, true, slack)) return Node{*place, 0, 1, true, {}};
    if (const auto place = room_.nearest(i, wanted, false, slack)) return Node{*place, 0, 1, false, {}};
    return {};
  }

  void place_tips(std::size_t i) {
    for (const geom::Region& region : held_[i]) place_tips(i, region);
  }

  /// Each area is held by what is below itself: a branch that passes beside it bears nothing of it.
  void place_tips(std::size_t i, const geom::Region& region) {
    const double apart = s_.tree_tip_distance_mm * kNm;
    std::vector<Point> own;
    const geom::AreaGrid grid(geom::offset({region}, from_mm(tip_mm_)));
    for (const Node& n : nodes_)
      if (grid.contains(n.at)) own.push_back(n.at);
    const auto near = [&](const Point& p, double within) {
      return std::any_of(own.begin(), own.end(),
                         [&](const Point& q) { return geom::distance(p, q) < within; });
    };
    const auto put = [&](const Node& tip) {
      nodes_.push_back(tip);
      own.push_back(tip.at);
    };
    const std::vector<Point> places = tip_places({region}, tip_mm_ * kNm, apart);
    for (const Point& wanted : places) {
      if (near(wanted, kCrowded * apart)) continue;
      if (const auto tip = tip_at(i, wanted)) put(*tip);
    }
    // However near its neighbours are, an area of its own needs a branch of its own.
    const auto inside = [&](const Point& p) { return geom::contains(region, p); };
    for (const Point& wanted : places) {
      if (std::any_of(own.begin(), own.end(), inside)) break;
      if (const auto tip = tip_at(i, wanted)) put(*tip);
    }
    // Where all that is near a place left tips out, or moved aside, none may be near enough.
    bool missed = false;
    for (const Point& p : samples(region, kSampleShare * apart)) {
      if (near(p, kReach * apart)) continue;
      const auto tip = tip_at(i, p);
      if (tip && !near(tip->at, 0.5 * kReach * apart)) put(*tip);
      missed = missed || !near(p, kReach * apart);
    }
    if (missed) leave_unheld(i, region, own);
  }

  void leave_unheld(std::size_t i, const geom::Region& region, const std::vector<Point>& tips) {
    geom::Rings discs;
    for (const Point& p : tips)
      discs.push_back(geom::make_circle(p, from_mm(kReach * s_.tree_tip_distance_mm), 16));
    append(out_.unheld[i],
           geom::remove_small(quick_subtract({region}, geom::unite(discs)), kMinUnheldMm2 * kNm * kNm));
  }

  double wanted_radius_mm(const Node& node, std::size_t i) const {
    double r = std::max(tip_mm_ + kTaper * node.depth_mm, kCarryShare * tip_mm_ * std::sqrt(node.tips));
    r = std::min(r, std::max(0.5 * s_.tree_branch_diameter_mm, tip_mm_));
    if (node.plate && node.depth_mm > 0) r += std::max(0.0, kFootMm - stack_[i].span.bottom_mm);
    return r;
  }

  /// Sections of this layer; branches that stand on the part end here.
  void record(std::size_t i) {
    for (Node& node : nodes_) {
      const double wanted = wanted_radius_mm(node, i);
      const double room = room_.clearance(i, node.at, wanted * kNm).distance / kNm;
      for (const std::size_t k : node.above) out_.sections[i + 1][k].below = out_.sections[i].size();
      node.above = {out_.sections[i].size()};
      out_.sections[i].push_back({node.at, std::min(wanted, room), {}});
    }
    std::erase_if(nodes_, [&](const Node& n) { return !n.plate && room_.rests(i, n.at); });
  }

  /// Whether a branch may be at q in layer i.
  bool good(const Node& node, std::size_t i, const Point& q) const {
    return node.plate ? room_.reaches_plate(i, q) : room_.reaches_anything(i, q);
  }

  /// Where each would like to go: away from the part if it is cramped, else towards its neighbour.
  Point wish(std::size_t k, std::size_t i) const {
    const Node& node = nodes_[k];
    const double step = room_.step(i);
    double left = step;
    Point to = node.at;
    const double wanted = wanted_radius_mm(node, i - 1) * kNm;
    const auto clear = room_.clearance(i - 1, node.at, wanted);
    if (clear.distance < wanted && clear.from != node.at) {
      const double push = std::min(step, wanted - clear.distance);
      const double d = geom::distance(node.at, clear.from);
      to = moved(to, static_cast<double>(node.at.x - clear.from.x) / d * push,
                 static_cast<double>(node.at.y - clear.from.y) / d * push);
      left -= push;
    }
    const Node* mate = nullptr;
    double best = std::min(kSeekMm * kNm, 2 * kMeetShare * lean_ * stack_[i].span.bottom_mm * kNm);
    for (std::size_t m = 0; m < nodes_.size(); ++m) {
      if (m == k || nodes_[m].plate != node.plate) continue;
      const double d = geom::distance(nodes_[m].at, node.at);
      if (d >= best) continue;
      best = d;
      mate = &nodes_[m];
    }
    return mate != nullptr ? towards(to, mate->at, std::min(left, 0.5 * best)) : to;
  }

  void descend(std::size_t i) {
    std::vector<Point> to(nodes_.size());
    for (std::size_t k = 0; k < nodes_.size(); ++k) to[k] = wish(k, i);
    const double step = room_.step(i);
    std::vector<bool> stuck(nodes_.size(), false);
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      Node& node = nodes_[k];
      const Point from = node.at;
      node.depth_mm += stack_[i].span.height_mm();
      const Point half = towards(from, to[k], 0.5 * geom::distance(from, to[k]));
      if (good(node, i - 1, to[k])) {
        node.at = to[k];
      } else if (good(node, i - 1, half)) {
        node.at = half;
      } else if (const auto out = room_.nearest(i - 1, from, node.plate, kMaxEscape * step)) {
        node.at = *out;
      } else {
        stuck[k] = true;
      }
    }
    merge(i - 1, stuck);
  }

  /// Branches that have met become one.
  void merge(std::size_t i, std::vector<bool>& gone) {
    const double near = std::max(room_.step(i), 0.1 * kNm);
    for (std::size_t a = 0; a < nodes_.size(); ++a) {
      if (gone[a]) continue;
      for (std::size_t b = a + 1; b < nodes_.size(); ++b) {
        if (gone[b] || nodes_[a].plate != nodes_[b].plate) continue;
        if (geom::distance(nodes_[a].at, nodes_[b].at) > near) continue;
        nodes_[a].tips += nodes_[b].tips;
        nodes_[a].depth_mm = std::max(nodes_[a].depth_mm, nodes_[b].depth_mm);
        nodes_[a].above.insert(nodes_[a].above.end(), nodes_[b].above.begin(), nodes_[b].above.end());
        gone[b] = true;
      }
    }
    std::vector<Node> left;
    for (std::size_t k = 0; k < nodes_.size(); ++k)
      if (!gone[k]) left.push_back(nodes_[k]);
    nodes_ = std::move(left);
  }

  const std::vector<Regions>& held_;
  const slice::LayerStack& stack_;
  const TreeRoom& room_;
  const SliceSettings& s_;
  const run::Context& ctx_;
  double tip_mm_ = 0;
  double lean_ = 0;
  std::vector<Node> nodes_;
  Branches out_;
};

}  // namespace

std::vector<Point> tip_places(const Regions& area, double tip_radius, double apart) {
  std::vector<Point> out;
  const auto add = [&](const Point& p) {
    for (const Point& q : out)
      if (geom::distance(p, q) < kCrowded * apart) return;
    out.push_back(p);
  };
  for (const auto& region : area) {
    Regions core;
    for (double share = 1; core.empty() && share > 0.1; share *= 0.5)
      core = geom::offset({region}, -std::llround(share * tip_radius));
    if (core.empty()) core = {region};
    for (const auto& ring : geom::rings_of(core)) {
      const double whole = geom::perimeter(ring);
      const double pieces = std::max(1.0, std::ceil(whole / apart));
      double next = 0;
      double along = 0;
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point& a = ring[i];
        const Point& b = ring[(i + 1) % ring.size()];
        const double d = geom::distance(a, b);
        for (; next <= along + d && next < whole - 1; next += whole / pieces)
          add(towards(a, b, next - along));
        along += d;
      }
    }
    const auto box = geom::bounds(region.outer);
    const geom::AreaGrid grid(core);
    const double row = apart * std::sqrt(0.75);  // of triangles
    const auto index = [](geom::Coord c, double by) {
      return static_cast<long>(std::floor(static_cast<double>(c) / by));
    };
    for (long y = index(box->min.y, row); y <= index(box->max.y, row) + 1; ++y)
      for (long x = index(box->min.x, apart) - 1; x <= index(box->max.x, apart) + 1; ++x) {
        const Point p{std::llround((static_cast<double>(x) + (y % 2 == 0 ? 0.0 : 0.5)) * apart),
                      std::llround(static_cast<double>(y) * row)};
        if (grid.contains(p)) add(p);
      }
  }
  return out;
}

Branches grow_branches(const std::vector<Regions>& held, const slice::LayerStack& stack, const TreeRoom& room,
                       const SliceSettings& settings, const run::Context& ctx) {
  return Grower(held, stack, room, settings, ctx).run();
}

}  // namespace voidpath::toolpath
