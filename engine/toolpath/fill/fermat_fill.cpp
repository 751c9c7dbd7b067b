#include "engine/toolpath/fill/fermat_fill.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/bead_area.h"
#include "engine/toolpath/fill/concentric_fill.h"
#include "engine/toolpath/fill/contour_tree.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

/// Notation. A chain is contours c1 … ck, each beside the next; c0 is the contour of the parent chain that c1
/// lies beside, if any. All are cut by one window: between the points A and B of each, A and B one after the
/// other along the contour. The long way from B to A is printed. Through the window each contour goes on to
/// the next but one: A0 → B2, A1 → B3, …; so two arms wind inwards, c2 c4 … and c1 c3 …. Their ends meet at
/// Ak and Ak-1; printed one inwards, the other outwards, they are one line from A0 to B0.
namespace voidpath::toolpath {

namespace {

using geom::Point;
using geom::Polyline;
using geom::Ring;

/// Length of a window, in spacings: with three, the lines through it keep 0.83 of a spacing.
constexpr double kWindowSpacings = 3.0;
/// A contour alone is entered and left by two lines side by side.
constexpr double kLoneWindowSpacings = 1.0;
/// Contours shorter than this many windows are cut by a shorter one.
constexpr double kMinWindows = 4.0;
/// The window's ends on neighbouring contours may be this many spacings apart.
constexpr double kMaxStep = 2.2;
/// Windows tried along the innermost contour of a chain.
constexpr int kTries = 32;
/// Between windows of one contour stays this many spacings of line.
constexpr double kApart = 0.5;

/// Around windows, lines are looked at within this many spacings.
constexpr double kMarginSpacings = 2.5;
/// Gaps narrower than this share of a bead are left to the squeeze of their neighbours.
constexpr double kLeastGap = 0.4;

/// A stretch of a ring, from a on by `length` nm in the ring's direction (forward) or against it.
struct Window {
  double a = 0;  ///< along the ring
  double length = 0;
  bool forward = true;
};

/// A ring and what is cut out of it: its chain's own window, and those of the chains beside it.
struct Track {
  const Ring* ring = nullptr;
  double total = 0;
  std::vector<double> along;  ///< of its vertices
  std::vector<Window> windows;

  void set(const Ring& r) {
    ring = &r;
    for (std::size_t k = 0; k < r.size(); ++k) {
      along.push_back(total);
      total += geom::distance(r[k], r[(k + 1) % r.size()]);
    }
  }
  double wrapped(double s) const {
    s = std::fmod(s, total);
    return s < 0 ? s + total : s;
  }
  Point at(double s) const {
    s = wrapped(s);
    const auto next = std::upper_bound(along.begin(), along.end(), s);
    const auto k = static_cast<std::size_t>(next - along.begin() - 1);
    const Point &p = (*ring)[k], &q = (*ring)[(k + 1) % ring->size()];
    const double d = geom::distance(p, q);
    const double t = d > 0 ? std::min((s - along[k]) / d, 1.0) : 0;
    return {p.x + std::llround(t * static_cast<double>(q.x - p.x)),
            p.y + std::llround(t * static_cast<double>(q.y - p.y))};
  }
  static double low(const Window& w) { return w.forward ? w.a : w.a - w.length; }
  double end(const Window& w) const { return wrapped(w.forward ? w.a + w.length : w.a - w.length); }
  Point point_a(const Window& w) const { return at(w.a); }
  Point point_b(const Window& w) const { return at(end(w)); }
  /// Whether the window is clear of those there are.
  bool free(const Window& w, double apart) const {
    return std::all_of(windows.begin(), windows.end(), [&](const Window& o) {
      const double ahead = wrapped(low(o) - low(w));
      return ahead >= w.length + apart && total - ahead >= o.length + apart;
    });
  }
};

class Spirals {
 public:
  Spirals(const ContourForest& forest, double spacing_nm) : forest_(forest), spacing_(spacing_nm) {
    tracks_.resize(forest.contours.size());
    beside_.resize(forest.contours.size());
    for (std::size_t i = 0; i < tracks_.size(); ++i) tracks_[i].set(forest.contours[i].ring);
  }

  geom::Polylines run() {
    geom::Polylines out;
    std::vector<std::uint32_t> open(forest_.roots.rbegin(), forest_.roots.rend());
    // Chains that find no place for a window beside their parent begin a line of their own.
    while (!open.empty()) {
      const std::uint32_t root = open.back();
      open.pop_back();
      out.push_back(chain(root, nullptr, open).value_or(Polyline{}));
    }
    return out;
  }

  /// Where windows are, and a margin around them.
  geom::Regions around_windows(double margin_nm) const {
    geom::Rings boxes;
    const geom::Coord margin = std::llround(margin_nm);
    for (const Track& t : tracks_)
      for (const Window& w : t.windows) {
        const geom::Box box = grown(*geom::bounds(Ring{t.point_a(w), middle(t, w), t.point_b(w)}), margin);
        boxes.push_back(geom::make_rectangle(box.min, box.max));
      }
    return geom::unite(boxes);
  }

 private:
  using Chain = std::vector<std::uint32_t>;

  Chain chain_from(std::uint32_t c) const {
    Chain out{c};
    while (forest_.contours[c].children.size() == 1) out.push_back(c = forest_.contours[c].children.front());
    return out;
  }

  /// The line over a chain and all beyond it, from A0 to B0 or, without a parent, from c1 to c1. Its window
  /// in the parent is left in `in_parent`. Nothing when there is no room for a window.
  std::optional<Polyline> chain(std::uint32_t root, std::pair<std::uint32_t, Window>* in_parent,
                                std::vector<std::uint32_t>& orphans) {
    Chain c = chain_from(root);
    // As much of the chain as one window can cut; the rest becomes a chain of its own.
    std::vector<Window> cut;
    for (; !c.empty(); c.pop_back()) {
      cut = window(c, in_parent);
      if (!cut.empty() || c.size() == 1) break;
    }
    if (cut.empty() && in_parent != nullptr) return std::nullopt;
    if (cut.empty()) cut.push_back(plain_window(c.front()));
    for (std::size_t i = 0; i < c.size(); ++i) tracks_[c[i]].windows.push_back(cut[i]);
    for (const std::uint32_t child : forest_.contours[c.back()].children) {
      std::pair<std::uint32_t, Window> place{c.back(), {}};
      std::optional<Polyline> line = chain(child, &place, orphans);
      if (!line) {
        orphans.push_back(child);
        continue;
      }
      tracks_[c.back()].windows.push_back(place.second);
      beside_[c.back()].push_back({place.second, std::move(*line)});
    }
    return line_of(c, cut, in_parent);
  }

  Window plain_window(std::uint32_t c) const {
    return {0, std::min(kWindowSpacings * spacing_, tracks_[c].total / kMinWindows), true};
  }

  /// One window through the chain, and through the parent: tried in many places along the innermost contour
  /// and carried outwards, where each point of a contour has the next one a spacing away.
  std::vector<Window> window(const Chain& c, std::pair<std::uint32_t, Window>* in_parent) const {
    std::vector<Window> best;
    double least = 1e300;
    const Track& inner = tracks_[c.back()];
    const double wanted = (c.size() > 1 ? kWindowSpacings : kLoneWindowSpacings) * spacing_;
    const double length = std::min(wanted, inner.total / kMinWindows);
    if (length <= 0) return best;
    for (int k = 0; k < kTries; ++k) {
      Window w{inner.total * k / kTries, length, true};
      double cost = bend(inner, w);
      std::vector<Window> cut(c.size());
      cut.back() = w;
      bool good = true;
      for (std::size_t i = c.size() - 1; i-- > 0 && good;) {
        good = carry(tracks_[c[i + 1]], cut[i + 1], tracks_[c[i]], cut[i], wanted, cost);
      }
      Window outer;
      if (good && in_parent != nullptr) {
        const Track& parent = tracks_[in_parent->first];
        good = carry(tracks_[c.front()], cut.front(), parent, outer, wanted, cost) &&
               parent.free(outer, kApart * spacing_);
      }
      if (!good || cost >= least) continue;
      least = cost;
      best = cut;
      if (in_parent != nullptr) in_parent->second = outer;
    }
    return best;
  }

  /// What a window's line lacks of being straight, nm.
  static double bend(const Track& t, const Window& w) {
    return w.length - geom::distance(t.point_a(w), t.point_b(w));
  }

  /// The window beside one on the contour further in.
  bool carry(const Track& from, const Window& w, const Track& to, Window& out, double window_nm,
             double& cost) const {
    const OnRing a = nearest_on_ring(*to.ring, from.point_a(w));
    const OnRing b = nearest_on_ring(*to.ring, from.point_b(w));
    if (std::max(a.distance, b.distance) > kMaxStep * spacing_) return false;
    const double ahead = to.wrapped(b.along - a.along);
    out.a = a.along;
    out.forward = ahead <= to.total - ahead;
    out.length = out.forward ? ahead : to.total - ahead;
    const double wanted = std::min(window_nm, to.total / kMinWindows);
    if (out.length < 0.5 * wanted || out.length > 2.5 * wanted) return false;
    cost += std::abs(a.distance - spacing_) + std::abs(b.distance - spacing_) + bend(to, out);
    return true;
  }

  /// The long way from B to A of a contour, with the lines of the chains beside it put in at their windows.
  Polyline arc(std::uint32_t c, const Window& own) const {
    const Track& t = tracks_[c];
    struct Stop {
      double at;  ///< from B on, in the direction of printing
      const std::pair<Window, Polyline>* beside;
      std::size_t vertex;
    };
    const double b = t.end(own);
    const double whole = t.total - own.length;
    auto from_b = [&](double along) { return own.forward ? t.wrapped(along - b) : t.wrapped(b - along); };
    std::vector<Stop> stops;
    for (std::size_t k = 0; k < t.along.size(); ++k) stops.push_back({from_b(t.along[k]), nullptr, k});
    for (const auto& chain : beside_[c]) {
      const double at = std::min(from_b(chain.first.a), from_b(t.end(chain.first)));
      std::erase_if(stops, [&](const Stop& s) {
        return s.beside == nullptr && s.at >= at && s.at <= at + chain.first.length;
      });
      stops.push_back({at, &chain, 0});
    }
    std::stable_sort(stops.begin(), stops.end(), [](const Stop& x, const Stop& y) { return x.at < y.at; });
    Polyline out{t.point_b(own)};
    for (const Stop& s : stops) {
      if (s.at <= 0 || s.at >= whole) continue;
      if (s.beside == nullptr) {
        out.push_back((*t.ring)[s.vertex]);
        continue;
      }
      // The line leads from its A0 to its B0, which lie here one way round or the other.
      const Polyline& line = s.beside->second;
      if (s.beside->first.forward == own.forward)
        out.insert(out.end(), line.begin(), line.end());
      else
        out.insert(out.end(), line.rbegin(), line.rend());
    }
    out.push_back(t.point_a(own));
    return out;
  }

  Polyline line_of(const Chain& c, const std::vector<Window>& cut,
                   const std::pair<std::uint32_t, Window>* in_parent) const {
    Polyline out;
    const std::size_t k = c.size();
    auto add = [&](const Polyline& more, bool backwards) {
      if (backwards)
        out.insert(out.end(), more.rbegin(), more.rend());
      else
        out.insert(out.end(), more.begin(), more.end());
    };
    const Track& first = tracks_[c.front()];
    if (in_parent != nullptr)
      out.push_back(tracks_[in_parent->first].point_a(in_parent->second));
    else if (k > 1)
      out.push_back(middle(first, cut.front()));
    for (std::size_t i = 1; i < k; i += 2) add(arc(c[i], cut[i]), false);
    // Where the arms meet, the window of the innermost contour is filled as far as its middle.
    if (k > 1) into_middle(tracks_[c.back()], cut.back(), k % 2 == 0, out);
    for (std::size_t i = k - 1 - (k - 1) % 2 + 2; i >= 2; i -= 2) add(arc(c[i - 2], cut[i - 2]), true);
    if (in_parent != nullptr) {
      const Track& parent = tracks_[in_parent->first];
      if (k > 1) out.push_back(middle(parent, in_parent->second));  // fills the parent's window likewise
      out.push_back(parent.point_b(in_parent->second));
    } else if (k == 1) {
      out.push_back(middle(first, cut.front()));
    }
    return out;
  }

  /// From A along the contour to the middle of its window, or from there to A.
  static void into_middle(const Track& t, const Window& w, bool from_a, Polyline& out) {
    Polyline line{t.point_a(w)};
    const double half = 0.5 * w.length;
    std::vector<std::pair<double, std::size_t>> corners;
    for (std::size_t k = 0; k < t.along.size(); ++k) {
      const double at = w.forward ? t.wrapped(t.along[k] - w.a) : t.wrapped(w.a - t.along[k]);
      if (at > 0 && at < half) corners.emplace_back(at, k);
    }
    std::sort(corners.begin(), corners.end());
    for (const auto& [at, k] : corners) line.push_back((*t.ring)[k]);
    line.push_back(middle(t, w));
    if (from_a)
      out.insert(out.end(), line.begin() + 1, line.end());
    else
      out.insert(out.end(), line.rbegin(), line.rend() - 1);
  }

  static Point middle(const Track& t, const Window& w) {
    return t.at(w.forward ? w.a + 0.5 * w.length : w.a - 0.5 * w.length);
  }

  const ContourForest& forest_;
  double spacing_;
  std::vector<Track> tracks_;
  std::vector<std::vector<std::pair<Window, Polyline>>> beside_;  ///< lines that go out from each contour
};

/// What the lines leave open where they pass through windows: they do not keep their distance there.
geom::Regions open_windows(const Spirals& spirals, const geom::Polylines& lines, const geom::Regions& area,
                           double spacing_nm) {
  const geom::Regions looked_at = spirals.around_windows(kMarginSpacings * spacing_nm);
  const geom::Regions beads = bead_area(geom::clip_inside(lines, looked_at), spacing_nm);
  // Beads that run beside what is looked at cover its rim.
  const geom::Regions inside = geom::offset(looked_at, -std::llround(spacing_nm));
  const geom::Regions left = quick_subtract(quick_intersect(area, inside), beads);
  return geom::remove_small(geom::open(left, std::llround(0.5 * kLeastGap * spacing_nm)),
                            kLeastGap * spacing_nm * spacing_nm);
}

}  // namespace

RingFill fermat_fill(const geom::Region& domain, const BeadSize& bead) {
  const ContourForest forest = contour_forest(domain, bead);
  RingFill out{{{}, false, bead.spacing_mm()}, forest.gaps};
  const double spacing = bead.spacing_mm() * geom::kNmPerMm;
  Spirals spirals(forest, spacing);
  for (auto& line : spirals.run())
    if (line.size() > 1) out.lines.lines.push_back(std::move(line));
  geom::Regions open = open_windows(spirals, out.lines.lines, around_centre_lines(domain, bead), spacing);
  append(out.gaps, quick_subtract(open, forest.gaps));
  return out;
}

}  // namespace voidpath::toolpath
