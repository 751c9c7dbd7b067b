#include "engine/toolpath/support/support_columns.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/lean.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/support/support_borders.h"

#include <algorithm>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Regions;

/// Columns smaller than this in section cannot stand, mm².
constexpr double kMinColumnMm2 = 2.0;
/// Support may be this much coarser than the part, mm: it keeps the xy gap anyway.
constexpr double kColumnToleranceMm = 0.05;
/// Lines may leave their column's border by this, mm, since they are simplified: it leans out so much less.
constexpr double kLineErrorMm = 0.03;
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

class Builder {
 public:
  Builder(const slice::LayerStack& stack, const SupportTask& task, const SliceSettings& s,
          const run::Context& ctx)
      : stack_(stack),
        task_(task),
        settings_(s),
        ctx_(ctx),
        contact_(s.support == SupportMode::plate ? above_plate(task, ctx) : task.contact),
        columns_(contact_.size()),
        carried_(contact_.size(), 1) {}

  std::vector<SupportAreas> run() {
    const std::size_t n = columns_.size();
    grow_down();
    const auto lattice = choose_lattice(columns_, contact_, settings_, ctx_);
    std::vector<SupportAreas> out(n);
    std::vector<ColumnBorders> borders(n);
    bool below_changed = false;
    run::parallel_after(
        ctx_, n, [&](std::size_t i) { below_changed = drop_unheld(i, below_changed); },
        [&](std::size_t i) {
          out[i].sparse = columns_[i];
          split_interface(contact_, i, out[i], settings_);
          if (lattice == nullptr || (i > 0 && columns_[i] == columns_[i - 1])) return;
          const double width = i == 0 ? settings_.first_layer_line_width_mm : settings_.line_width_mm;
          borders[i] = find_borders(columns_[i], *lattice, width, settings_);
        });
    if (lattice == nullptr) return out;
    for (std::size_t i = 1; i < n; ++i)
      if (columns_[i] == columns_[i - 1]) borders[i] = borders[i - 1];
    border_columns(out, columns_, borders, lattice, settings_, ctx_);
    return out;
  }

 private:
  /// From the top down: every column with what it gathers. What is carried as long as nothing below changes
  /// is found meanwhile.
  void grow_down() {
    const std::size_t n = columns_.size();
    Regions column;
    run::parallel_after(
        ctx_, n,
        [&](std::size_t step) {
          const std::size_t i = n - 1 - step;
          const Regions& fresh = contact_[i];
          const Regions above = column;
          column = quick_unite(column, fresh);
          if (column.empty()) return;
          const bool as_above = fresh.empty() && step > 0 && task_.forbidden[i] == task_.forbidden[i + 1];
          if (!as_above) column = stand(column, above, task_.forbidden[i], settings_);
          columns_[i] = column;
        },
        [&](std::size_t step) {
          if (step > 0) carried_[n - step] = stand_of(n - step).carries_all() ? 1 : 0;
        });
  }

  Stand stand_of(std::size_t i) const {
    const std::size_t bearer = layer_below_gap(stack_, i, settings_.support_z_gap_mm);
    return {columns_[i], columns_[i - 1], bearer < stack_.size() ? &stack_[bearer].regions : nullptr,
            from_mm(support_lean_mm(settings_, stack_[i].span.height_mm()) - kLineErrorMm)};
  }

  /// From the plate up: the column without what nothing below carries; beside a part, room begins above it
  /// that had none below. Whether that was any.
  bool drop_unheld(std::size_t i, bool below_changed) {
    if (i == 0) return false;
    const Stand stand = stand_of(i);
    if (below_changed ? stand.carries_all() : carried_[i] != 0) return false;
    Regions held = stand.held(settings_);
    const bool changed = held != columns_[i];
    columns_[i] = std::move(held);
    return changed;
  }

  const slice::LayerStack& stack_;
  const SupportTask& task_;
  const SliceSettings& settings_;
  const run::Context& ctx_;
  std::vector<Regions> contact_;
  std::vector<Regions> columns_;
  std::vector<char> carried_;  ///< by the column below as it was grown
};

}  // namespace

std::vector<SupportAreas> support_columns(const slice::LayerStack& stack, const SupportTask& task,
                                          const SliceSettings& settings, const run::Context& ctx) {
  return Builder(stack, task, settings, ctx).run();
}

}  // namespace voidpath::toolpath
