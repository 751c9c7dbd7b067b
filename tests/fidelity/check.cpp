#include "tests/fidelity/check.h"

#include "tests/fidelity/ground.h"
#include "tests/fidelity/mask.h"
#include "tests/fidelity/sections.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <memory>
#include <numbers>
#include <optional>

namespace voidpath::fidelity {

namespace {

/// Empty plate around the part, mm.
constexpr double kBorder = 3;
/// Strands are looked at this often, mm.
constexpr double kSample = 0.1;
/// Area that may stay uncovered: this share of the section, and a strip along its border whose width is this
/// share of a line.
constexpr double kAreaShare = 0.005;
constexpr double kBorderShare = 1.0;
/// Walls thinner than this are printed this wide, mm.
constexpr double kThinnestBead = 0.3;
/// Of a vase's outline a tip narrower than a line may be missing as far as this, mm.
constexpr double kVaseTip = 0.6;
/// Distances up to this many pixels are looked up one by one.
constexpr int kNearPixels = 4;
/// Ends of strands that meet, with the digits of their coordinates, mm.
constexpr double kSamePlace = 2e-3;

std::string place(std::size_t layer, const Layer& l, double x, double y) {
  const auto number = [](double v) {
    std::string s = std::to_string(static_cast<double>(std::lround(v * 100)) / 100);
    return s.substr(0, s.find('.') + 3);
  };
  return "layer " + std::to_string(layer) + " (z " + number(l.top) + ") at (" + number(x) + ", " + number(y) +
         ")";
}

void note(Worst& worst, double value, const std::string& where) {
  if (value > worst.value) worst = {value, where};
}

/// The part, and what stands around it.
Grid grid_for(const mesh::TriangleMesh& mesh, const Print& print, const Rules& rules) {
  mesh::Bounds b = mesh::bounds(mesh);
  for (const Layer& l : print.layers)
    for (const Bead& bead : l.beads) {
      if (!is_support(bead.kind) && bead.kind != Kind::brim) continue;
      b.min.x() = std::min({b.min.x(), bead.x0, bead.x1});
      b.min.y() = std::min({b.min.y(), bead.y0, bead.y1});
      b.max.x() = std::max({b.max.x(), bead.x0, bead.x1});
      b.max.y() = std::max({b.max.y(), bead.y0, bead.y1});
    }
  Grid g;
  g.x0 = b.min.x() - kBorder;
  g.y0 = b.min.y() - kBorder;
  const double width = b.size().x() + 2 * kBorder, depth = b.size().y() + 2 * kBorder;
  g.size = std::max(rules.largest_pixel, std::sqrt(width * depth / static_cast<double>(rules.most_pixels)));
  g.nx = static_cast<int>(std::ceil(width / g.size));
  g.ny = static_cast<int>(std::ceil(depth / g.size));
  return g;
}

class Checker {
 public:
  Checker(const mesh::TriangleMesh& mesh, const Print& print, const Rules& rules)
      : print_(print),
        rules_(rules),
        grid_(grid_for(mesh, print, rules)),
        sections_(mesh, print, rules_, grid_) {
    for (const Layer& l : print.layers) thickest_ = std::max(thickest_, l.height);
  }

  Findings run() {
    found_.layers = print_.layers.size();
    found_.pixel = grid_.size;
    double volume = 0, implied = 0;
    for (std::size_t i = 0; i < print_.layers.size(); ++i) {
      layer(i);
      volume += print_.layers[i].volume;
      implied += print_.layers[i].implied;
    }
    if (implied > 0) found_.volume_ratio = volume / implied;
    return found_;
  }

 private:
  bool is_spiral(std::size_t i) const { return rules_.vase && i >= rules_.floor_layers; }

  void layer(std::size_t i) {
    const Layer& l = print_.layers[i];
    Seen now;
    now.section = next_.most.empty() ? sections_.of(i) : std::move(next_);
    next_ = sections_.of(i + 1);
    now.part.assign(grid_.count(), 0);
    now.support.assign(grid_.count(), 0);
    now.top = l.top;
    now.bottom = l.top - l.height;
    for (const Bead& b : l.beads)
      if (b.kind != Kind::brim) draw(is_support(b.kind) ? now.support : now.part, grid_, b);
    if (is_spiral(i)) {
      spiral(i, now);
    } else {
      outside(i, now.section.most, now.part);
      covered(i, now);
      const Mask none(grid_.count(), 0);
      surface(i, now, is_spiral(i + 1) ? none : next_.most, found_.top_hole);
      surface(i, now, below_.empty() ? none : below_.back().section.most, found_.bottom_hole);
    }
    brim(i, now);
    held(i);
    below_.push_back(std::move(now));
    while (below_.front().top < l.top - Ground::reach(rules_, thickest_)) below_.pop_front();
  }

  std::pair<double, double> middle(std::size_t pixel) const {
    const std::size_t nx = static_cast<std::size_t>(grid_.nx);
    return {grid_.x0 + (static_cast<double>(pixel % nx) + 0.5) * grid_.size,
            grid_.y0 + (static_cast<double>(pixel / nx) + 0.5) * grid_.size};
  }

  void note_pixel(Worst& worst, double value, std::size_t i, std::size_t pixel) {
    if (value <= worst.value) return;
    const auto [x, y] = middle(pixel);
    note(worst, value, place(i, print_.layers[i], x, y));
  }

  /// Where the part is thinner than the thinnest bead, that bead reaches out on both sides and must: there
  /// the distance counts from where it would end on the thin wall's other side.
  void outside(std::size_t i, const Mask& section, const Mask& part) {
    std::vector<float> far, to_wide;  // made when first wanted
    for (std::size_t p = 0; p < section.size(); ++p) {
      if (part[p] == 0 || section[p] != 0) continue;
      double d = 0;
      if (const auto close = near(section, grid_, p, kNearPixels)) {
        d = *close;
      } else {
        if (far.empty()) far = distance_to(section, grid_);
        d = static_cast<double>(far[p]);
      }
      if (d <= found_.outside.value) continue;
      if (to_wide.empty())
        to_wide = distance_to(
            grown(shrunk(section, grid_, 0.5 * kThinnestBead), grid_, 0.5 * kThinnestBead + grid_.size),
            grid_);
      const bool thin = static_cast<double>(to_wide[p]) > d + 2 * grid_.size;
      note_pixel(found_.outside, d - (thin ? 0.5 * kThinnestBead : 0), i, p);
    }
  }

  void covered(std::size_t i, const Seen& now) {
    if (rules_.infill_density < 1) return;
    std::size_t border = 0;
    for (int y = 0; y + 1 < grid_.ny; ++y)
      for (int x = 0; x + 1 < grid_.nx; ++x) {
        const auto here = now.section.least[grid_.at(x, y)];
        border += here != now.section.least[grid_.at(x + 1, y)] ? 1u : 0u;
        border += here != now.section.least[grid_.at(x, y + 1)] ? 1u : 0u;
      }
    const double perimeter = static_cast<double>(border) * grid_.size * std::numbers::pi / 4;
    const double area = static_cast<double>(count(now.section.least)) * grid_.area();
    const double bare = static_cast<double>(count(without(now.section.least, now.part))) * grid_.area();
    const double allowed = kAreaShare * area + kBorderShare * rules_.line_width * perimeter;
    if (allowed > 0) note(found_.uncovered, bare / allowed, place(i, print_.layers[i], 0, 0));
    if (perimeter > 0) note(found_.inset, bare / perimeter, place(i, print_.layers[i], 0, 0));
  }

  /// What of this layer the other one leaves open must be closed, a line width from its border on.
  void surface(std::size_t i, const Seen& now, const Mask& other, Worst& worst) {
    const Window all = cropped(without(now.section.least, other), grid_, 0);
    if (all.mask.empty()) return;
    const double by = rules_.line_width / grid_.size;
    // Most of what is open is a narrow strip along the border.
    const Mask wide = shrunk_square(all.mask, all.grid, static_cast<int>(by / std::numbers::sqrt2));
    const Window core = cropped(wide, all.grid, static_cast<int>(by) + 2);
    if (core.mask.empty()) return;
    const Mask open = core.same(all.mask, all.grid);
    const Mask part = core.same(all.same(now.part, grid_), all.grid);
    // At the window's edge only what the square left is to be believed.
    const Mask inner = both(core.mask, shrunk(open, core.grid, rules_.line_width));
    const Mask bare = without(inner, part);
    if (count(bare) == 0) return;
    Mask inverse(bare.size());
    for (std::size_t p = 0; p < bare.size(); ++p) inverse[p] = bare[p] == 0;
    const auto depth = distance_to(inverse, core.grid);
    for (std::size_t p = 0; p < bare.size(); ++p)
      if (bare[p] != 0)
        note_pixel(worst, static_cast<double>(depth[p]), i, all.whole(core.whole(p, all.grid), grid_));
  }

  /// The wall leads from the outline of the layer below to its own.
  void spiral(std::size_t i, const Seen& now) {
    Mask either = now.section.most;
    Mask border = rim(now.section.least);
    const Mask from = below_.empty() ? border : rim(below_.back().section.most);
    if (!below_.empty())
      for (std::size_t p = 0; p < either.size(); ++p) either[p] |= below_.back().section.most[p];
    outside(i, either, now.part);
    const auto to_wall = distance_to(now.part, grid_), to_below = distance_to(from, grid_);
    const double half = 0.5 * rules_.line_width + grid_.size;
    const Mask wide = grown(shrunk(now.section.least, grid_, half), grid_, half);
    for (std::size_t p = 0; p < border.size(); ++p)
      if (border[p] != 0)
        note_pixel(found_.wall_gap,
                   static_cast<double>(to_wall[p] - to_below[p]) - (wide[p] == 0 ? kVaseTip : 0), i, p);
  }

  /// Pixels of an area with a neighbour that is none of it.
  Mask rim(const Mask& area) const {
    const Mask inner = shrunk_square(area, grid_, 1);
    return without(area, inner);
  }

  void brim(std::size_t i, const Seen& now) {
    Mask mask;
    for (const Bead& b : print_.layers[i].beads) {
      if (b.kind != Kind::brim) continue;
      if (mask.empty()) mask.assign(grid_.count(), 0);
      draw(mask, grid_, b);
      found_.brim_mm += std::hypot(b.x1 - b.x0, b.y1 - b.y0);
    }
    if (mask.empty()) return;
    Mask inverse = now.section.least, stands = now.part;
    for (std::size_t p = 0; p < mask.size(); ++p) inverse[p] ^= 1u, stands[p] |= now.support[p];
    const auto depth = distance_to(inverse, grid_), away = distance_to(stands, grid_);
    for (std::size_t p = 0; p < mask.size(); ++p)
      if (mask[p] != 0) {
        note_pixel(found_.brim_inside, static_cast<double>(depth[p]), i, p);
        note_pixel(found_.brim_away, static_cast<double>(away[p]), i, p);
      }
  }

  /// Height of what the strand is to lie on. What hangs round hangs from the layer's own bottom.
  static double underside(const Layer& l, const Bead& b) {
    const double bottom = l.top - l.height;
    return b.round || b.climbs ? bottom : std::min(bottom, b.top - b.height);
  }

  struct Run {
    double length = 0, unannounced = 0;
    double x = 0, y = 0;
    bool from_end = false;  ///< began where a strand begins
    bool support = false;
  };

  void close(std::optional<Run>& run, std::size_t i, bool at_end) {
    if (!run) return;
    const std::string where = place(i, print_.layers[i], run->x, run->y);
    if (run->support) {
      note(run->from_end || at_end ? found_.support_loose : found_.support_span, run->length, where);
    } else if (run->from_end || at_end) {
      found_.loose_mm += run->length;
      note(found_.loose, run->length, where);
    } else if (run->unannounced > 0) {
      found_.unannounced_mm += run->unannounced;
      note(found_.unannounced, run->unannounced, where);
    }
    run.reset();
  }

  /// Of layers up to this height.
  void cast_shadow(double up_to) {
    for (const Seen& s : below_) {
      if (s.top <= shadow_top_ || s.top > up_to + kSamePlace) continue;
      if (shadow_.empty()) shadow_.assign(grid_.count(), 0);
      for (std::size_t p = 0; p < shadow_.size(); ++p) shadow_[p] |= s.section.most[p];
      shadow_top_ = s.top;
    }
  }

  void held(std::size_t i) {
    const Layer& l = print_.layers[i];
    std::map<long, std::unique_ptr<Ground>> grounds;  // by the underside, µm
    const auto ground_of = [&](const Bead& b) -> Ground& {
      const double z = underside(l, b);
      auto& g = grounds[std::lround(1000 * z)];
      if (!g) g = std::make_unique<Ground>(below_, rules_, grid_, z, l.height);
      return *g;
    };
    if (rules_.from_plate) cast_shadow(l.top - l.height - rules_.support_z_gap);
    std::optional<Nearby> shadow;
    if (!shadow_.empty()) shadow.emplace(shadow_, grid_);
    const auto excused = [&](double x, double y) {
      const auto p = grid_.pixel(x, y);
      return shadow && p && shadow->within(*p, rules_.line_width);
    };
    std::optional<Run> run;
    const Bead* before = nullptr;
    for (const Bead& b : l.beads) {
      const bool joined = before != nullptr && before->kind != Kind::brim &&
                          is_support(before->kind) == is_support(b.kind) &&
                          std::hypot(b.x0 - before->x1, b.y0 - before->y1) < kSamePlace;
      if (!joined) close(run, i, true);
      before = &b;
      if (b.kind == Kind::brim) continue;
      const bool support = is_support(b.kind);
      const double length = std::hypot(b.x1 - b.x0, b.y1 - b.y0);
      (support ? found_.support_mm : found_.length_mm) += length;
      Ground& ground = ground_of(b);
      const int n = std::max(1, static_cast<int>(std::ceil(length / kSample)));
      for (int k = 0; k < n; ++k) {
        const double t = (k + 0.5) / n;
        const double x = b.x0 + t * (b.x1 - b.x0), y = b.y0 + t * (b.y1 - b.y0);
        if (support ? ground.holds_support(x, y, b.kind == Kind::roof)
                    : ground.holds(x, y) || excused(x, y)) {
          close(run, i, false);
          continue;
        }
        if (!run) run = Run{0, 0, x, y, !joined && k == 0, support};
        run->length += length / n;
        if (b.kind != Kind::bridge) run->unannounced += length / n;
      }
    }
    close(run, i, true);
  }

  const Print& print_;
  const Rules& rules_;
  Grid grid_;
  Sections sections_;
  double thickest_ = 0;  ///< layer, mm
  Section next_;
  std::deque<Seen> below_;
  Mask shadow_;            ///< of the part, where that matters, up to...
  double shadow_top_ = 0;  ///< ...this height, mm
  Findings found_;
};

}  // namespace

Findings check(const mesh::TriangleMesh& mesh, const Print& print, const Rules& rules) {
  return Checker(mesh, print, rules).run();
}

}  // namespace voidpath::fidelity
