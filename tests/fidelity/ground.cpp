#include "tests/fidelity/ground.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voidpath::fidelity {

namespace {

/// Heights come with three digits, and what lies on what is known by sums of two, mm.
constexpr double kSameHeight = 2e-3;
/// A strand is held by one it overlaps by so much of its width, whatever the angle says.
constexpr double kOverlap = 0.25;

double leaning(double height, double angle_deg) {
  return height * std::tan(angle_deg * std::numbers::pi / 180);
}

void add(Mask& to, const Mask& what) {
  if (to.empty()) to.assign(what.size(), 0);
  for (std::size_t p = 0; p < to.size(); ++p) to[p] |= what[p];
}

/// With gaps up to twice as wide filled.
Mask closed(const Mask& mask, const Grid& grid, double by) {
  Mask out = mask;
  const Window w = cropped(mask, grid, static_cast<int>(by / grid.size) + 2);
  if (w.mask.empty()) return out;
  const Mask wide = shrunk(grown(w.mask, w.grid, by), w.grid, by);
  for (std::size_t p = 0; p < wide.size(); ++p) out[w.whole(p, grid)] |= wide[p];
  return out;
}

bool near(std::optional<Nearby>& what, std::size_t pixel, double reach) {
  return what.has_value() && what->within(pixel, reach);
}

}  // namespace

double Ground::reach(const Rules& rules, double thickest_layer) {
  return 2 * rules.support_z_gap + 3 * thickest_layer;
}

Ground::Ground(const std::deque<Seen>& below, const Rules& rules, const Grid& grid, double underside,
               double height)
    : below_(below), rules_(rules), grid_(grid) {
  const double overlap = kOverlap * rules.line_width;
  lean_ = std::max(leaning(height, rules.support_angle_deg), overlap) + grid.size;
  support_lean_ = std::max(leaning(height, rules.branch_angle_deg), overlap) + grid.size;
  sparse_ = std::max(rules.line_width / std::max(rules.infill_density, 0.02), lean_);
  between_ = 0.6 * rules.line_width / std::max(rules.support_density, 0.02) + grid.size;
  beside_ = std::max(lean_, rules.support_reach + grid.size);
  roof_lean_ = std::max(support_lean_, 0.5 * rules.line_width / std::max(rules.support_density, 0.02));
  near_plate_ = !support_fits(rules.ground, underside);
  on_plate_ = underside <= kSameHeight;
  for (const Seen& s : below)
    if (s.top <= underside + kSameHeight) under_ = &s;
  if (under_ == nullptr) return;
  part_.emplace(under_->part, grid);
  own_below_ = closed(under_->support, grid, between_);
  own_support_.emplace(own_below_, grid);
  look_down(underside);
  if (!held_up_.empty()) {
    held_up_ = closed(held_up_, grid, between_);
    support_.emplace(held_up_, grid);
  }
  if (!close_below_.empty()) close_.emplace(close_below_, grid);
  if (!rest_.empty()) rests_.emplace(rest_, grid);
  if (!near_plate_ || rules.ground <= 0) return;
  for (const Seen& s : below)
    if (s.top < rules.ground) raft_top_ = s.support;
  if (!raft_top_.empty()) raft_.emplace(raft_top_, grid);
}

/// Whether a layer of support lies above `from` and a gap below `to`.
bool Ground::support_fits(double from, double to) const {
  return std::any_of(below_.begin(), below_.end(), [&](const Seen& s) {
    return s.bottom >= from - kSameHeight && s.top <= to - rules_.support_z_gap + kSameHeight;
  });
}

void Ground::look_down(double underside) {
  Mask open(grid_.count(), 1);  // where the part itself has a gap down to the layer looked at
  const double gap = rules_.support_z_gap;
  bool first_below_gap = true;
  for (auto s = below_.rbegin(); s != below_.rend(); ++s) {
    if (s->top > underside + kSameHeight) continue;
    if (!support_fits(s->top + gap, underside)) add(close_below_, both(open, s->part));
    if (s->top <= underside - gap + kSameHeight && first_below_gap) {
      // The highest layer that keeps the gap: what is to hold stands there, or what support stands on.
      first_below_gap = false;
      held_up_ = s->support;
      rest_ = both(open, s->part);
    }
    open = without(open, s->section.least);
  }
}

bool Ground::holds(double x, double y) {
  const auto p = grid_.pixel(x, y);
  if (near_plate_ && rules_.ground <= 0) return true;
  if (!p || under_ == nullptr) return false;
  if (near(part_, *p, under_->section.most[*p] != 0 ? sparse_ : lean_)) return true;
  return near(support_, *p, beside_) || near(close_, *p, lean_) || near(raft_, *p, lean_);
}

bool Ground::holds_support(double x, double y, bool roof) {
  if (on_plate_) return true;
  const auto p = grid_.pixel(x, y);
  if (!p) return false;
  const double lean = roof ? roof_lean_ : support_lean_;
  return near(own_support_, *p, lean) || near(rests_, *p, lean);
}

}  // namespace voidpath::fidelity
