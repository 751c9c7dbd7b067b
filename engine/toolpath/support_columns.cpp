#include "engine/toolpath/support_columns.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Regions;

/// Columns smaller than this in section cannot stand, mm².
constexpr double kMinColumnMm2 = 2.0;
/// Support may be this much coarser than the part, mm: it keeps the xy gap anyway.
constexpr double kColumnToleranceMm = 0.05;
constexpr double kMm2 = geom::kNmPerMm * geom::kNmPerMm;

/// The part of a column that has room and can stand.
Regions stand(const Regions& column, const Regions& forbidden, const SliceSettings& settings) {
  Regions out = quick_subtract(geom::simplify(column, from_mm(kColumnToleranceMm)), forbidden);
  out = geom::open(out, from_mm(0.5 * settings.line_width_mm));
  return geom::remove_small(out, kMinColumnMm2 * kMm2);
}

/// The top layers of a column become dense.
void split_interface(const std::vector<Regions>& contact, std::size_t i, SupportAreas& areas,
                     const SliceSettings& settings) {
  if (areas.sparse.empty() || settings.support_interface_layers <= 0) return;
  Regions near;
  const auto layers = static_cast<std::size_t>(settings.support_interface_layers);
  for (std::size_t k = i; k < std::min(contact.size(), i + layers); ++k) near = quick_unite(near, contact[k]);
  if (near.empty()) return;
  areas.interface = quick_intersect(areas.sparse, near);
  areas.sparse = geom::open(quick_subtract(areas.sparse, near), from_mm(0.5 * settings.line_width_mm));
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

std::vector<SupportAreas> support_columns(const SupportTask& task, const SliceSettings& settings,
                                          const run::Context& ctx) {
  const std::size_t n = task.contact.size();
  std::vector<SupportAreas> out(n);
  const std::vector<Regions> contact =
      settings.support == SupportMode::plate ? above_plate(task, ctx) : task.contact;
  Regions column;
  for (std::size_t i = n; i-- > 0;) {
    ctx.check();
    const Regions& fresh = contact[i];
    column = quick_unite(column, fresh);
    if (column.empty()) continue;
    const bool as_above = fresh.empty() && i + 1 < n && task.forbidden[i] == task.forbidden[i + 1];
    if (!as_above) column = stand(column, task.forbidden[i], settings);
    out[i].sparse = column;
  }
  run::parallel_for(ctx, n, [&](std::size_t i) { split_interface(contact, i, out[i], settings); });
  return out;
}

}  // namespace voidpath::toolpath
