#include "engine/toolpath/support/trim_support.h"

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/lean.h"
#include "engine/toolpath/line_index.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/support/held_pieces.h"
#include "engine/toolpath/support/support_borders.h"
#include "engine/toolpath/support/support_task.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <span>
#include <unordered_set>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Point;
using geom::Polyline;

/// Lines are looked at this often, mm.
constexpr double kSampleMm = 0.2;
/// The tip of a line may stick out by this, mm: less than its own width.
constexpr double kTipMm = 0.3;
/// What is shorter, mm, hangs no further than about its own width and stays.
constexpr double kDotMm = 0.4;
/// Between two held places a line may hang over this share of what sparse lines are apart: it is looked at
/// here and there.
constexpr double kSpanShare = 0.95;
/// Dense lines may stick out by this share of it.
constexpr double kDenseTipShare = 0.5;
/// Pieces shorter than this hold nothing, mm.
constexpr double kLeastPieceMm = 0.6;
/// Between two lines is what no disc reaches whose radius is this share of their distance.
constexpr double kBetweenShare = 0.68;
/// Such discs are laid over a place with their middles beside it in so many directions, so far away as a
/// share of their radius...
struct Discs {
  double away;
  int directions;
};
constexpr Discs kDiscs[] = {{1.0, 16}, {0.65, 10}, {0.3, 5}};
/// ...and reach over it by this at least, mm.
constexpr double kTouchMm = 0.05;

struct Segment {
  Point a, b;
  bool operator==(const Segment&) const = default;
};
struct SegmentHash {
  std::size_t operator()(const Segment& s) const {
    std::uint64_t h = 0;
    for (const geom::Coord c : {s.a.x, s.a.y, s.b.x, s.b.y})
      h = (h ^ static_cast<std::uint64_t>(c)) * 0x9E3779B97F4A7C15u, h ^= h >> 29;
    return static_cast<std::size_t>(h);
  }
};
Segment segment(const Point& a, const Point& b) {
  return std::pair(b.x, b.y) < std::pair(a.x, a.y) ? Segment{b, a} : Segment{a, b};
}

Polyline whole_line(const Path& path) {
  Polyline out = path.points;
  if (path.closed && !out.empty()) out.push_back(out.front());
  return out;
}

geom::Box box_of(const Point& a, const Point& b) {
  return {{std::min(a.x, b.x), std::min(a.y, b.y)}, {std::max(a.x, b.x), std::max(a.y, b.y)}};
}

template <class Visit>
void each_segment(std::span<const Path> paths, Visit&& visit) {
  for (const Path& p : paths) {
    for (std::size_t k = 1; k < p.points.size(); ++k) visit(p.points[k - 1], p.points[k]);
    if (p.closed && p.points.size() > 1) visit(p.points.back(), p.points.front());
  }
}

/// What carries one layer's lines.
class Carrier {
 public:
  /// `part`: what support may stand on, or null.
  Carrier(const std::vector<Path>& below, const geom::Regions* part, double lean_mm, double half_line_mm,
          double apart_mm, const geom::Box& box)
      : lean_((lean_mm + half_line_mm) * geom::kNmPerMm),
        dense_lean_(std::max(lean_, (kDenseTipShare * apart_mm + half_line_mm) * geom::kNmPerMm)),
        between_(kBetweenShare * apart_mm * geom::kNmPerMm),
        index_(grown(box, from_mm(apart_mm)), from_mm(1.0)) {
    const geom::Box near = grown(box, from_mm(apart_mm));
    each_segment(below, [&](const Point& a, const Point& b) {
      if (overlap(box_of(a, b), near)) index_.add(a, b);
    });
    if (part == nullptr) return;
    geom::Regions rest = quick_intersect(*part, {{geom::make_rectangle(near.min, near.max), {}}});
    if (!rest.empty()) part_.emplace(std::move(rest));
  }

  bool carries(const Point& p, bool dense) const {
    if (index_.size() > 0) {
      if (index_.reaches(p, dense ? dense_lean_ : lean_)) return true;
      if (index_.reaches(p, between_) && enclosed(p)) return true;
    }
    return part_ && part_->contains(p);
  }

 private:
  /// Whether every disc that reaches over p touches a line.
  bool enclosed(const Point& p) const {
    const double reach = between_ - kTouchMm * geom::kNmPerMm;
    for (const Discs& discs : kDiscs)
      for (int k = 0; k < discs.directions; ++k) {
        const double a = 2 * std::numbers::pi * k / discs.directions, away = discs.away * reach;
        const Point q{p.x + std::llround(away * std::cos(a)), p.y + std::llround(away * std::sin(a))};
        if (!index_.reaches(q, reach)) return false;
      }
    return true;
  }

  double lean_, dense_lean_, between_;  ///< nm
  LineIndex index_;
  std::optional<geom::AreaGrid> part_;
};

std::vector<Stretch> stretches_of(const Polyline& line, const Carrier& carrier, bool dense) {
  std::vector<Stretch> out;
  for (std::size_t k = 1; k < line.size(); ++k) {
    const Point &a = line[k - 1], &b = line[k];
    const double length = geom::distance(a, b);
    const int n = std::max(1, static_cast<int>(std::ceil(length / (kSampleMm * geom::kNmPerMm))));
    const auto at = [&](double t) {
      return Point{a.x + std::llround(t * static_cast<double>(b.x - a.x)),
                   a.y + std::llround(t * static_cast<double>(b.y - a.y))};
    };
    for (int j = 0; j < n; ++j) {
      const bool held = carrier.carries(at((j + 0.5) / n), dense);
      if (out.empty() || out.back().held != held)
        out.push_back({{j == 0 ? a : at(static_cast<double>(j) / n)}, held});
      out.back().points.push_back(j + 1 == n ? b : at(static_cast<double>(j + 1) / n));
    }
  }
  return out;
}

/// Of each line of a layer, what is left; nothing where it is left as it is.
using Cuts = std::vector<std::optional<std::vector<Path>>>;

/// Where lines of a layer were cut.
class Boxes {
 public:
  Boxes(const std::vector<Path>& lines, const Cuts& cuts) {
    for (std::size_t k = 0; k < lines.size(); ++k)
      if (cuts[k]) boxes_.push_back(*geom::bounds(lines[k].points));
  }
  bool empty() const { return boxes_.empty(); }
  bool touch(const geom::Box& box) const {
    return std::any_of(boxes_.begin(), boxes_.end(), [&](const geom::Box& b) { return overlap(b, box); });
  }

 private:
  std::vector<geom::Box> boxes_;
};

std::vector<Path> cut(std::vector<Path>&& lines, Cuts&& cuts) {
  std::vector<Path> out;
  out.reserve(lines.size());
  for (std::size_t k = 0; k < lines.size(); ++k)
    if (cuts[k])
      std::move(cuts[k]->begin(), cuts[k]->end(), std::back_inserter(out));
    else
      out.push_back(std::move(lines[k]));
  return out;
}

class Trimmer {
 public:
  Trimmer(const slice::LayerStack& stack, const SliceSettings& s)
      : stack_(stack), settings_(s), apart_mm_(support_line_distance_mm(s, s.support_density)) {}

  /// Looks at the lines of layer i that lie in `where`, or at all.
  void trim(const std::vector<Path>& own, const std::vector<Path>& below, std::size_t i, const Boxes* where,
            Cuts& cuts) const {
    std::vector<char> in_question(own.size(), 1);
    std::optional<geom::Box> box;
    for (std::size_t k = 0; k < own.size(); ++k) {
      const auto b = geom::bounds(own[k].points);
      in_question[k] = b && (where == nullptr || where->touch(grown(*b, from_mm(apart_mm_))));
      if (in_question[k]) box = box ? joined(*box, *b) : *b;
    }
    if (!box) return;
    find_new(own, below, *box, in_question);
    box.reset();
    for (std::size_t k = 0; k < own.size(); ++k)
      if (in_question[k]) {
        cuts[k].reset();
        const auto b = geom::bounds(own[k].points);
        box = box ? joined(*box, *b) : *b;
      }
    if (!box) return;
    const std::size_t bearer = layer_below_gap(stack_, i, settings_.support_z_gap_mm);
    const double lean = support_lean_mm(settings_, stack_[i].span.height_mm());
    const Carrier carrier(below, bearer < stack_.size() ? &stack_[bearer].regions : nullptr, lean,
                          0.5 * settings_.line_width_mm, apart_mm_, *box);
    for (std::size_t k = 0; k < own.size(); ++k)
      if (in_question[k]) cuts[k] = carried(own[k], carrier);
  }

 private:
  static geom::Box joined(const geom::Box& a, const geom::Box& b) {
    return {{std::min(a.min.x, b.min.x), std::min(a.min.y, b.min.y)},
            {std::max(a.max.x, b.max.x), std::max(a.max.y, b.max.y)}};
  }

  /// Of the lines in question, those that do not lie on a line like them.
  static void find_new(const std::vector<Path>& own, const std::vector<Path>& below, const geom::Box& box,
                       std::vector<char>& in_question) {
    std::unordered_set<Segment, SegmentHash> same;
    each_segment(below, [&](const Point& a, const Point& b) {
      if (overlap(box_of(a, b), box)) same.insert(segment(a, b));
    });
    for (std::size_t k = 0; k < own.size(); ++k) {
      if (!in_question[k]) continue;
      bool fresh = false;
      each_segment({&own[k], 1},
                   [&](const Point& a, const Point& b) { fresh = fresh || !same.contains(segment(a, b)); });
      in_question[k] = fresh;
    }
  }

  /// What is carried of a path; nothing when it is left as it is.
  std::optional<std::vector<Path>> carried(const Path& path, const Carrier& carrier) const {
    const bool dense = path.role == Role::support_interface;
    const Polyline line = whole_line(path);
    std::vector<Stretch> stretches = stretches_of(line, carrier, dense);
    const bool uniform = stretches.size() == 1;
    if (uniform && (stretches.front().held || geom::length(line) < kDotMm * geom::kNmPerMm))
      return std::nullopt;
    double all = 0, kept = 0, hanging = 0;
    for (const Stretch& s : stretches) {
      all += geom::length(s.points);
      if (!s.held) hanging = std::max(hanging, geom::length(s.points));
    }
    // A loop that hangs somewhere must begin where it is held, and not where it is reached best.
    const bool anywhere = !path.closed || hanging < kTipMm * geom::kNmPerMm;
    std::vector<Polyline> pieces =
        held_pieces(std::move(stretches), path.closed, kTipMm, kSpanShare * apart_mm_);
    for (const Polyline& p : pieces) kept += geom::length(p);
    if (anywhere && pieces.size() == 1 && kept > all - kTipMm * geom::kNmPerMm) return std::nullopt;
    std::vector<Path> out;
    for (Polyline& p : pieces) {
      if (geom::length(p) < kLeastPieceMm * geom::kNmPerMm) continue;
      Path piece = path;
      piece.closed = false;
      piece.points = geom::simplify(p, 1);
      out.push_back(std::move(piece));
    }
    return out;
  }

  const slice::LayerStack& stack_;
  const SliceSettings& settings_;
  double apart_mm_;
};

}  // namespace

void trim_support(std::vector<std::vector<Path>*>& lines, const slice::LayerStack& stack,
                  const SliceSettings& settings, const run::Context& ctx) {
  if (settings.support_density <= 0) return;
  const Trimmer trimmer(stack, settings);
  // Most lines stay as they are: what is above them is known at once.
  std::vector<Cuts> cuts(lines.size());
  run::parallel_for(ctx, lines.size(), [&](std::size_t i) {
    cuts[i].resize(lines[i]->size());
    if (i > 0) trimmer.trim(*lines[i], *lines[i - 1], i, nullptr, cuts[i]);
  });
  std::optional<Boxes> below;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    ctx.check();
    if (below) trimmer.trim(*lines[i], *lines[i - 1], i, &*below, cuts[i]);
    below.emplace(*lines[i], cuts[i]);
    if (below->empty())
      below.reset();
    else
      *lines[i] = cut(std::move(*lines[i]), std::move(cuts[i]));
  }
}

}  // namespace voidpath::toolpath
