#include "tests/fidelity/check.h"

#include "tests/fidelity/mask.h"

#include <algorithm>
#include <cmath>
#include <deque>
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
/// Distances up to this many pixels are looked up one by one.
constexpr int kNearPixels = 4;
/// Digits of the cut heights, mm.
constexpr double kCutError = 1e-5;
/// How many layers down support may lie below what it holds, beyond its gap.
constexpr std::size_t kSupportLayers = 4;

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

Grid grid_for(const mesh::TriangleMesh& mesh, const Rules& rules) {
  const mesh::Bounds b = mesh::bounds(mesh);
  Grid g;
  g.x0 = b.min.x() - kBorder;
  g.y0 = b.min.y() - kBorder;
  const double width = b.size().x() + 2 * kBorder, depth = b.size().y() + 2 * kBorder;
  g.size = std::max(rules.largest_pixel, std::sqrt(width * depth / static_cast<double>(rules.most_pixels)));
  g.nx = static_cast<int>(std::ceil(width / g.size));
  g.ny = static_cast<int>(std::ceil(depth / g.size));
  return g;
}

/// Where the mesh's triangles pass the height. A corner exactly there counts as above.
std::vector<Edge> section(const mesh::TriangleMesh& mesh, const std::vector<std::uint32_t>& triangles,
                          double z) {
  std::vector<Edge> out;
  for (const std::uint32_t t : triangles) {
    const auto& corner = mesh.triangles[t];
    const mesh::Vec3* v[3] = {&mesh.vertices[corner[0]], &mesh.vertices[corner[1]],
                              &mesh.vertices[corner[2]]};
    // Counter-clockwise corners seen from outside: the edge that comes down lies left of the one that goes
    // up.
    std::optional<geom::Vec3> from, to;
    for (int k = 0; k < 3; ++k) {
      const mesh::Vec3 &a = *v[k], &b = *v[(k + 1) % 3];
      const bool above_a = a.z() >= z, above_b = b.z() >= z;
      if (above_a == above_b) continue;
      // The same two corners in the same order, whichever triangle asks: neighbours meet exactly.
      const bool swap = above_a;
      const mesh::Vec3 &low = swap ? b : a, &high = swap ? a : b;
      const double s = (z - low.z()) / (high.z() - low.z());
      const geom::Vec3 p = low + s * (high - low);
      (above_b ? to : from) = p;
    }
    if (from && to) out.push_back({from->x(), from->y(), to->x(), to->y()});
  }
  return out;
}

class Checker {
 public:
  Checker(const mesh::TriangleMesh& mesh, const Print& print, const Rules& rules)
      : mesh_(mesh), print_(print), rules_(rules), grid_(grid_for(mesh, rules)) {
    sort_triangles();
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
  /// A face may lie in the very height of the cut, and digits decide which side counts: both are right.
  struct Section {
    Mask most, least;
  };
  struct Seen {
    Section section;
    Mask part, support;
    double top = 0;
  };

  double cut(const Layer& l) const { return l.top - 0.5 * l.height; }

  void sort_triangles() {
    by_layer_.resize(print_.layers.size());
    std::vector<double> cuts;
    for (const Layer& l : print_.layers) cuts.push_back(cut(l));
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      double low = 1e300, high = -1e300;
      for (const auto v : mesh_.triangles[t]) {
        low = std::min(low, mesh_.vertices[v].z());
        high = std::max(high, mesh_.vertices[v].z());
      }
      auto first = std::lower_bound(cuts.begin(), cuts.end(), low - kCutError);
      for (; first != cuts.end() && *first <= high + kCutError; ++first)
        by_layer_[static_cast<std::size_t>(first - cuts.begin())].push_back(t);
    }
  }

  /// Whether a corner lies in the height of the cut.
  bool grazed(const std::vector<std::uint32_t>& triangles, double z) const {
    for (const std::uint32_t t : triangles)
      for (const auto v : mesh_.triangles[t])
        if (std::abs(mesh_.vertices[v].z() - z) <= kCutError) return true;
    return false;
  }

  Section section_of(std::size_t i) const {
    if (i >= print_.layers.size()) return {Mask(grid_.count(), 0), Mask(grid_.count(), 0)};
    const double z = cut(print_.layers[i]);
    Mask low = fill(section(mesh_, by_layer_[i], z - kCutError), grid_);
    if (!grazed(by_layer_[i], z)) return {low, low};
    Mask high = fill(section(mesh_, by_layer_[i], z + kCutError), grid_);
    if (low == high) return {low, std::move(high)};
    Mask most = low;
    for (std::size_t p = 0; p < most.size(); ++p) most[p] |= high[p];
    return {std::move(most), both(low, high)};
  }

  void layer(std::size_t i) {
    const Layer& l = print_.layers[i];
    Seen now;
    now.section = next_.most.empty() ? section_of(i) : std::move(next_);
    next_ = section_of(i + 1);
    now.part.assign(grid_.count(), 0);
    now.support.assign(grid_.count(), 0);
    now.top = l.top;
    for (const Bead& b : l.beads)
      if (b.kind != Kind::brim) draw(b.kind == Kind::support ? now.support : now.part, grid_, b);
    outside(i, now);
    covered(i, now);
    const Mask none(grid_.count(), 0);
    surface(i, now, next_.most, found_.top_hole);
    surface(i, now, below_.empty() ? none : below_.back().section.most, found_.bottom_hole);
    if (i > 0) held(i, now);
    below_.push_back(std::move(now));
    if (below_.size() > kSupportLayers) below_.pop_front();
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
  void outside(std::size_t i, const Seen& now) {
    std::vector<float> far, to_wide;  // made when first wanted
    const Mask& section = now.section.most;
    for (std::size_t p = 0; p < section.size(); ++p) {
      if (now.part[p] == 0 || section[p] != 0) continue;
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

  /// What lies under a layer: whether a strand of it has something to lie on.
  class Ground {
   public:
    Ground(const Checker& c, std::size_t i)
        : rules_(c.rules_), grid_(c.grid_), under_(c.below_.back()), part_(under_.part, c.grid_) {
      const Layer& l = c.print_.layers[i];
      const double bottom = l.top - l.height;
      lean_ = std::max(l.height * std::tan(rules_.support_angle_deg * std::numbers::pi / 180),
                       0.25 * rules_.line_width) +
              grid_.size;
      sparse_ = std::max(rules_.line_width / std::max(rules_.infill_density, 0.02), lean_);
      between_ = 0.6 * rules_.line_width / std::max(rules_.support_density, 0.02) + grid_.size;
      on_plate_ = bottom <= rules_.support_z_gap + l.height + kCutError;
      Mask open(grid_.count(), 1);  // where the part itself has a gap down to the layer looked at
      for (auto s = c.below_.rbegin(); s != c.below_.rend(); ++s) {
        if (s->top < bottom - rules_.support_z_gap - 2 * l.height) break;
        if (s->top <= bottom - rules_.support_z_gap + 1e-6) {
          if (held_up_.empty()) held_up_.assign(grid_.count(), 0), close_below_ = held_up_;
          for (std::size_t p = 0; p < held_up_.size(); ++p) {
            held_up_[p] |= s->support[p];
            if (open[p] != 0) close_below_[p] |= s->part[p];
          }
        }
        open = without(open, s->section.most);
      }
      if (!held_up_.empty()) {
        support_.emplace(held_up_, grid_);
        close_.emplace(close_below_, grid_);
      }
    }

    bool holds(double x, double y) {
      if (on_plate_) return true;
      const int i = static_cast<int>(std::floor((x - grid_.x0) / grid_.size));
      const int j = static_cast<int>(std::floor((y - grid_.y0) / grid_.size));
      if (i < 0 || j < 0 || i >= grid_.nx || j >= grid_.ny) return false;
      const std::size_t p = grid_.at(i, j);
      if (part_.within(p, under_.section.most[p] != 0 ? sparse_ : lean_)) return true;
      return support_.has_value() && (support_->within(p, between_) || close_->within(p, lean_));
    }

   private:
    const Rules& rules_;
    const Grid& grid_;
    const Seen& under_;
    Nearby part_;
    Mask held_up_;      ///< by support a gap below
    Mask close_below_;  ///< the part under a gap of its own no deeper than support's
    std::optional<Nearby> support_, close_;
    double lean_ = 0, sparse_ = 0, between_ = 0;
    bool on_plate_ = false;
  };

  struct Run {
    double length = 0, unannounced = 0;
    double x = 0, y = 0;
    bool from_end = false;  ///< began where a strand begins
  };

  void held(std::size_t i, const Seen&) {
    Ground ground(*this, i);
    const Layer& l = print_.layers[i];
    std::optional<Run> run;
    const Bead* before = nullptr;
    const auto close = [&](bool at_end) {
      if (!run) return;
      if (run->from_end || at_end) {
        found_.loose_mm += run->length;
        note(found_.loose, run->length, place(i, l, run->x, run->y));
      } else if (run->unannounced > 0) {
        found_.unannounced_mm += run->unannounced;
        note(found_.unannounced, run->unannounced, place(i, l, run->x, run->y));
      }
      run.reset();
    };
    for (const Bead& b : l.beads) {
      if (b.kind == Kind::brim || b.kind == Kind::support) {
        close(true);
        before = nullptr;
        continue;
      }
      const bool joined = before != nullptr && std::hypot(b.x0 - before->x1, b.y0 - before->y1) < 2e-3;
      if (!joined) close(true);
      const double length = std::hypot(b.x1 - b.x0, b.y1 - b.y0);
      found_.length_mm += length;
      const int n = std::max(1, static_cast<int>(std::ceil(length / kSample)));
      for (int k = 0; k < n; ++k) {
        const double t = (k + 0.5) / n;
        const double x = b.x0 + t * (b.x1 - b.x0), y = b.y0 + t * (b.y1 - b.y0);
        if (ground.holds(x, y)) {
          close(false);
          continue;
        }
        if (!run) run = Run{0, 0, x, y, !joined && k == 0};
        run->length += length / n;
        if (b.kind != Kind::bridge) run->unannounced += length / n;
      }
      before = &b;
    }
    close(true);
  }

  const mesh::TriangleMesh& mesh_;
  const Print& print_;
  const Rules& rules_;
  Grid grid_;
  std::vector<std::vector<std::uint32_t>> by_layer_;
  Section next_;
  std::deque<Seen> below_;
  Findings found_;
};

}  // namespace

Findings check(const mesh::TriangleMesh& mesh, const Print& print, const Rules& rules) {
  return Checker(mesh, print, rules).run();
}

}  // namespace voidpath::fidelity
