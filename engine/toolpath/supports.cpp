#include "engine/toolpath/supports.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Regions;

/// Bridges longer than this sag and are supported, mm.
constexpr double kMaxBridgeMm = 12.0;
/// Support reaches this far beyond the overhang it holds, so that a steep slope's narrow steps still get a
/// column that can stand, mm.
constexpr double kMarginMm = 0.8;
/// Columns nearer to one another than twice this become one, which stands better, mm.
constexpr double kMergeMm = 0.75;
/// Overhang areas smaller than this within a layer are noise of slicing, mm².
constexpr double kMinOverhangMm2 = 0.01;
/// Columns smaller than this in section cannot stand, mm².
constexpr double kMinColumnMm2 = 2.0;
/// Overhangs that lean out less than this per layer are carried by the bead below, in line widths.
constexpr double kSelfSupportWidths = 0.25;
constexpr double kMm2 = geom::kNmPerMm * geom::kNmPerMm;
/// Heights that differ by less are equal, mm.
constexpr double kSameHeightMm = 1e-6;

class Builder {
 public:
  Builder(const slice::LayerStack& stack, const std::vector<Surfaces>& surfaces,
          const SliceSettings& settings, const run::Context& ctx)
      : stack_(stack), surfaces_(surfaces), settings_(settings), ctx_(ctx), n_(stack.size()) {}

  std::vector<SupportAreas> run() {
    std::vector<SupportAreas> out(n_);
    std::vector<Regions> overhang(n_);
    run::parallel_for(ctx_, n_, [&](std::size_t i) { overhang[i] = find_overhang(i); });
    if (std::all_of(overhang.begin(), overhang.end(), [](const Regions& r) { return r.empty(); })) return out;
    forbidden_.resize(n_);
    run::parallel_for(ctx_, n_, [&](std::size_t i) { forbidden_[i] = find_forbidden(i); });
    contact_.resize(n_);
    run::parallel_for(ctx_, n_, [&](std::size_t i) { place_contact(i, overhang[i]); });
    merge_contacts();
    if (settings_.support == SupportMode::plate) remove_above_part();
    drop_columns(out);
    run::parallel_for(ctx_, n_, [&](std::size_t i) { split_interface(i, out[i]); });
    return out;
  }

 private:
  double lean_mm(std::size_t i) const {
    const double angle = std::clamp(settings_.support_angle_deg, 0.0, 89.0) * std::numbers::pi / 180.0;
    return std::max(stack_[i].span.height_mm() * std::tan(angle),
                    kSelfSupportWidths * settings_.line_width_mm);
  }

  Regions find_overhang(std::size_t i) const {
    if (i == 0) return {};
    const Regions& own = stack_[i].regions;
    const Regions& below = stack_[i - 1].regions;
    if (own.empty() || own == below) return {};
    const geom::Coord lean = from_mm(lean_mm(i));
    Regions far = quick_subtract(own, geom::offset(below, lean));
    far = geom::remove_small(far, kMinOverhangMm2 * kMm2);
    if (far.empty()) return far;
    // What leans too far, back to where it leaves the layer below.
    Regions out = quick_subtract(quick_intersect(geom::offset(far, lean), own), below);
    for (const BridgeArea& bridge : surfaces_[i].bridges) {
      if (!bridge.anchored || bridge.span_mm > kMaxBridgeMm) continue;
      const double walls = settings_.line_width_mm * (settings_.perimeters + 1);
      out = quick_subtract(out, geom::offset({bridge.hanging}, from_mm(walls)));
    }
    return out;
  }

  /// Where support of layer i must not be: beside the part, and within the z gap above and below it.
  Regions find_forbidden(std::size_t i) const {
    Regions out = geom::offset(stack_[i].regions, from_mm(settings_.support_xy_gap_mm));
    const double gap = settings_.support_z_gap_mm - kSameHeightMm;
    for (std::size_t j = i + 1; j < n_ && stack_[j].span.bottom_mm < stack_[i].span.top_mm + gap; ++j)
      if (stack_[j].regions != stack_[i].regions) out = quick_unite(out, stack_[j].regions);
    for (std::size_t j = i; j-- > 0 && stack_[j].span.top_mm > stack_[i].span.bottom_mm - gap;)
      if (stack_[j].regions != stack_[i].regions) out = quick_unite(out, stack_[j].regions);
    return out;
  }

  /// For support from the plate alone: contacts with the part below them go. Contacts are by bearing layer.
  void remove_above_part() {
    Regions shadow;
    for (std::size_t i = 0; i < n_; ++i) {
      ctx_.check();
      if (i == 0 || forbidden_[i] != forbidden_[i - 1]) shadow = quick_unite(shadow, forbidden_[i]);
      if (!contact_[i].empty()) contact_[i] = quick_subtract(contact_[i], shadow);
    }
  }

  /// The highest layer whose top keeps the z gap below layer i; none: n_.
  std::size_t contact_layer(std::size_t i) const {
    const double limit = stack_[i].span.bottom_mm - settings_.support_z_gap_mm + kSameHeightMm;
    for (std::size_t k = i; k-- > 0;)
      if (stack_[k].span.top_mm <= limit) return k;
    return n_;
  }

  void place_contact(std::size_t i, const Regions& overhang) {
    if (overhang.empty() || contact_layer(i) == n_) return;
    contact_[i] = geom::offset(overhang, from_mm(kMarginMm), geom::Join::square);
  }

  /// Gathers the contacts by the layer that bears them.
  void merge_contacts() {
    std::vector<Regions> by_layer(n_);
    for (std::size_t i = 0; i < n_; ++i)
      if (!contact_[i].empty()) append(by_layer[contact_layer(i)], std::move(contact_[i]));
    run::parallel_for(ctx_, n_, [&](std::size_t i) {
      if (!by_layer[i].empty())
        by_layer[i] = geom::close(geom::unite(geom::rings_of(by_layer[i])), from_mm(kMergeMm));
    });
    contact_ = std::move(by_layer);
  }

  void drop_columns(std::vector<SupportAreas>& out) const {
    Regions column;
    for (std::size_t i = n_; i-- > 0;) {
      ctx_.check();
      const Regions& fresh = contact_[i];
      column = quick_unite(column, fresh);
      if (column.empty()) continue;
      const bool as_above = fresh.empty() && i + 1 < n_ && forbidden_[i] == forbidden_[i + 1];
      if (!as_above) column = stand(column, forbidden_[i]);
      out[i].sparse = column;
    }
  }

  /// The part of a column that has room and can stand.
  Regions stand(const Regions& column, const Regions& forbidden) const {
    Regions out = quick_subtract(geom::simplify(column, from_mm(kColumnToleranceMm)), forbidden);
    out = geom::open(out, from_mm(0.5 * settings_.line_width_mm));
    return geom::remove_small(out, kMinColumnMm2 * kMm2);
  }

  /// The top layers of a column become dense.
  void split_interface(std::size_t i, SupportAreas& areas) const {
    if (areas.sparse.empty() || settings_.support_interface_layers <= 0) return;
    Regions near;
    const auto layers = static_cast<std::size_t>(settings_.support_interface_layers);
    for (std::size_t k = i; k < std::min(n_, i + layers); ++k) near = quick_unite(near, contact_[k]);
    if (near.empty()) return;
    areas.interface = quick_intersect(areas.sparse, near);
    areas.sparse = geom::open(quick_subtract(areas.sparse, near), from_mm(0.5 * settings_.line_width_mm));
  }

  /// Support may be this much coarser than the part, mm: it keeps the xy gap anyway.
  static constexpr double kColumnToleranceMm = 0.05;

  const slice::LayerStack& stack_;
  const std::vector<Surfaces>& surfaces_;
  const SliceSettings& settings_;
  const run::Context& ctx_;
  std::size_t n_;
  std::vector<Regions> forbidden_;
  std::vector<Regions> contact_;  ///< first by the layer held, then by the layer that bears it
};

}  // namespace

Regions printed_area(const SupportAreas& areas) {
  return quick_unite(quick_unite(areas.sparse, areas.interface), areas.branches);
}

std::vector<SupportAreas> find_supports(const slice::LayerStack& stack, const std::vector<Surfaces>& surfaces,
                                        const SliceSettings& settings, const run::Context& ctx) {
  if (settings.support == SupportMode::none || stack.empty()) return std::vector<SupportAreas>(stack.size());
  return Builder(stack, surfaces, settings, ctx).run();
}

}  // namespace voidpath::toolpath
