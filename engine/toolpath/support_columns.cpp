#include "engine/toolpath/support_columns.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/support_borders.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Regions;

/// Columns smaller than this in section cannot stand, mm².
constexpr double kMinColumnMm2 = 2.0;
/// Support may be this much coarser than the part, mm: it keeps the xy gap anyway.
constexpr double kColumnToleranceMm = 0.05;
/// Columns lean out no further than this, whatever the part may, degrees from vertical.
constexpr double kMostLeanDeg = 60;
/// A line is carried by one beside it below that it overlaps by so much of its width.
constexpr double kCarriedShare = 0.25;
constexpr double kMm2 = geom::kNmPerMm * geom::kNmPerMm;

/// The part of a column that has room and can stand. What is as it was in the layer above stands.
Regions stand(const Regions& column, const Regions& above, const Regions& forbidden,
              const SliceSettings& settings) {
  Regions out, changed;
  for (geom::Region& r : quick_subtract(geom::simplify(column, from_mm(kColumnToleranceMm)), forbidden))
    (std::find(above.begin(), above.end(), r) != above.end() ? out : changed).push_back(std::move(r));
  append(out, geom::open(changed, from_mm(0.5 * settings.line_width_mm)));
  return geom::remove_small(out, kMinColumnMm2 * kMm2);
}

/// The top layers of a column become dense, and what is left beside them if it is too narrow for a line of
/// its own: dense layers above may lie on it.
void split_interface(const std::vector<Regions>& contact, std::size_t i, SupportAreas& areas,
                     const SliceSettings& settings) {
  if (areas.sparse.empty() || settings.support_interface_layers <= 0) return;
  Regions near;
  const auto layers = static_cast<std::size_t>(settings.support_interface_layers);
  for (std::size_t k = i; k < std::min(contact.size(), i + layers); ++k) near = quick_unite(near, contact[k]);
  if (near.empty()) return;
  const Regions column = std::move(areas.sparse);
  areas.sparse = geom::open(quick_subtract(column, near), from_mm(0.5 * settings.line_width_mm));
  areas.interface = quick_subtract(column, areas.sparse);
}

/// What one layer's column stands on, and how far it may lean out over it.
struct Stand {
  const Regions& column;
  const Regions& below;
  const Regions* part = nullptr;
  geom::Coord lean = 0;

  bool carries_all() const {
    if (column.empty() || column == below) return true;
    Regions fresh = quick_subtract(column, below);
    if (part != nullptr) fresh = quick_subtract(fresh, *part);
    return fresh.empty() || geom::open(fresh, lean / 2).empty();
  }

  Regions held(const SliceSettings& s) const {
    Regions out = geom::offset(below, lean);
    if (part != nullptr) out = quick_unite(out, *part);
    return geom::remove_small(geom::open(quick_intersect(column, out), from_mm(0.5 * s.line_width_mm)),
                              kMinColumnMm2 * kMm2);
  }
};

/// From the plate up, each column without what nothing below carries: beside a part, room begins above it
/// that had none below.
void drop_unheld(std::vector<Regions>& columns, const slice::LayerStack& stack, const SliceSettings& s,
                 const run::Context& ctx) {
  const double slope = std::tan(std::clamp(s.support_angle_deg, 0.0, kMostLeanDeg) * std::numbers::pi / 180);
  const auto stand_of = [&](std::size_t i) {
    const std::size_t bearer = layer_below_gap(stack, i, s.support_z_gap_mm);
    return Stand{columns[i], columns[i - 1], bearer < stack.size() ? &stack[bearer].regions : nullptr,
                 from_mm(std::max(slope * stack[i].span.height_mm(), kCarriedShare * s.line_width_mm))};
  };
  // Above what stays as it is, the answer is known at once.
  std::vector<char> carried(columns.size(), 1);
  run::parallel_for(ctx, columns.size(), [&](std::size_t i) {
    if (i > 0) carried[i] = stand_of(i).carries_all() ? 1 : 0;
  });
  bool below_changed = false;
  for (std::size_t i = 1; i < columns.size(); ++i) {
    ctx.check();
    const Stand stand = stand_of(i);
    const bool whole = below_changed ? stand.carries_all() : carried[i] != 0;
    below_changed = false;
    if (whole) continue;
    Regions held = stand.held(s);
    below_changed = held != columns[i];
    columns[i] = std::move(held);
  }
}

/// For support from the plate alone: the contacts, without what has the part or its gaps below.
std::vector<Regions> above_plate(const SupportTask& task, const run::Context& ctx) {
  std::vector<Regions> out = task.contact;
  Regions shadow;
  for (std::size_t i = 0; i < out.size(); ++i) {
    ctx.check();
    if (i == 0 || task.forbidden[i] != task.forbidden[i - 1]) shadow = quick_unite(shadow, task.forbidden[i]);
    if (!out[i].empty()) out[i] = quick_subtract(out[i], shadow);
  }
  return out;
}

}  // namespace

std::vector<SupportAreas> support_columns(const slice::LayerStack& stack, const SupportTask& task,
                                          const SliceSettings& settings, const run::Context& ctx) {
  const std::size_t n = task.contact.size();
  std::vector<SupportAreas> out(n);
  const std::vector<Regions> contact =
      settings.support == SupportMode::plate ? above_plate(task, ctx) : task.contact;
  std::vector<Regions> columns(n);
  Regions column;
  for (std::size_t i = n; i-- > 0;) {
    ctx.check();
    const Regions& fresh = contact[i];
    const Regions above = column;
    column = quick_unite(column, fresh);
    if (column.empty()) continue;
    const bool as_above = fresh.empty() && i + 1 < n && task.forbidden[i] == task.forbidden[i + 1];
    if (!as_above) column = stand(column, above, task.forbidden[i], settings);
    columns[i] = column;
  }
  drop_unheld(columns, stack, settings, ctx);
  run::parallel_for(ctx, n, [&](std::size_t i) {
    out[i].sparse = columns[i];
    split_interface(contact, i, out[i], settings);
  });
  border_narrow_columns(out, columns, contact, settings, ctx);
  return out;
}

}  // namespace voidpath::toolpath
