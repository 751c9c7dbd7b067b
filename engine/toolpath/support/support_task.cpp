#include "engine/toolpath/support/support_task.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/lean.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Regions;

/// Bridges longer than this sag and are supported, mm.
constexpr double kMaxBridgeMm = 12.0;
/// Support reaches this far beyond the overhang it holds, so that a steep slope's narrow steps still get a
/// column that can stand, mm.
constexpr double kMarginMm = 0.8;
/// Contacts nearer to one another than twice this become one, which stands better, mm.
constexpr double kMergeMm = 0.75;
/// Overhang areas smaller than this within a layer are noise of slicing, mm².
constexpr double kMinOverhangMm2 = 0.01;
/// Smaller strips of overhang than this are no bridges, mm²: mostly they are steps of a slope.
constexpr double kMinThinBridgeMm2 = 1.0;
constexpr double kMm2 = geom::kNmPerMm * geom::kNmPerMm;
/// Heights that differ by less are equal, mm.
constexpr double kSameHeightMm = 1e-6;

class Finder {
 public:
  Finder(const slice::LayerStack& stack, const std::vector<Surfaces>& surfaces, const SliceSettings& settings,
         const run::Context& ctx)
      : stack_(stack), surfaces_(surfaces), settings_(settings), ctx_(ctx), n_(stack.size()) {}

  SupportTask run() {
    std::vector<Regions> overhang(n_);
    run::parallel_for(ctx_, n_, [&](std::size_t i) { overhang[i] = find_overhang(i); });
    if (std::all_of(overhang.begin(), overhang.end(), [](const Regions& r) { return r.empty(); })) return {};
    forbidden_.resize(n_);
    run::parallel_for(ctx_, n_, [&](std::size_t i) { forbidden_[i] = find_forbidden(i); });
    contact_.resize(n_);
    run::parallel_for(ctx_, n_, [&](std::size_t i) { place_contact(i, overhang[i]); });
    merge_contacts();
    return {std::move(contact_), std::move(forbidden_)};
  }

 private:
  Regions find_overhang(std::size_t i) const {
    if (i == 0) return {};
    const Regions& own = stack_[i].regions;
    if (own.empty() || own == stack_[i - 1].regions) return {};
    // What is too small to be held holds nothing: the point that a strut begins with.
    const Regions below = geom::remove_small(stack_[i - 1].regions, kMinOverhangMm2 * kMm2);
    const geom::Coord lean = from_mm(lean_mm(settings_, stack_[i].span.height_mm()));
    Regions far = quick_subtract(own, geom::offset(below, lean));
    far = geom::remove_small(far, kMinOverhangMm2 * kMm2);
    if (far.empty()) return far;
    // What leans too far, back to where it leaves the layer below.
    Regions out = quick_subtract(quick_intersect(geom::offset(far, lean), own), below);
    const Regions leaning = out;
    for (const BridgeArea& bridge : surfaces_[i].bridges) {
      if (!bridge.anchored || bridge.span_mm > kMaxBridgeMm) continue;
      if (is_thin(bridge.hanging, 0.5 * settings_.line_width_mm) && !all_bridged(leaning, bridge, below))
        continue;
      const double walls = settings_.line_width_mm * (settings_.perimeters + 1);
      out = quick_subtract(out, geom::offset({bridge.hanging}, from_mm(walls)));
    }
    return without_thin_bridges(out, below);
  }

  static bool is_thin(const geom::Region& region, double half_mm) {
    return geom::offset({region}, -from_mm(half_mm)).empty();
  }

  /// Whether all that leans out around a bridge finds hold at both ends: a strip between walls that lead
  /// around a hole in the air says nothing about those.
  bool all_bridged(const Regions& leaning, const BridgeArea& bridge, const Regions& below) const {
    return std::all_of(leaning.begin(), leaning.end(), [&](const geom::Region& region) {
      return quick_intersect({region}, {bridge.hanging}).empty() ||
             plan_bridge(region, below, 0.5 * settings_.line_width_mm).anchored;
    });
  }

  /// What is too thin to have an inside is bridged by its walls, if they find hold at both ends.
  Regions without_thin_bridges(const Regions& overhang, const Regions& below) const {
    Regions out;
    const double walls = settings_.line_width_mm * std::max(settings_.perimeters, 1);
    for (const auto& region : overhang) {
      if (is_thin(region, walls) && geom::area(region) >= kMinThinBridgeMm2 * kMm2) {
        const BridgeArea bridge = plan_bridge(region, below, 0.5 * settings_.line_width_mm);
        if (bridge.anchored && bridge.span_mm <= kMaxBridgeMm && bridge.span_mm > 2 * walls) continue;
      }
      out.push_back(region);
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

  std::size_t contact_layer(std::size_t i) const {
    return layer_below_gap(stack_, i, settings_.support_z_gap_mm);
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

  const slice::LayerStack& stack_;
  const std::vector<Surfaces>& surfaces_;
  const SliceSettings& settings_;
  const run::Context& ctx_;
  std::size_t n_;
  std::vector<Regions> forbidden_;
  std::vector<Regions> contact_;  ///< first by the layer held, then by the layer that bears it
};

}  // namespace

std::size_t layer_below_gap(const slice::LayerStack& stack, std::size_t i, double z_gap_mm) {
  const double limit = stack[i].span.bottom_mm - z_gap_mm + kSameHeightMm;
  for (std::size_t k = i; k-- > 0;)
    if (stack[k].span.top_mm <= limit) return k;
  return stack.size();
}

SupportTask find_support_task(const slice::LayerStack& stack, const std::vector<Surfaces>& surfaces,
                              const SliceSettings& settings, const run::Context& ctx) {
  return Finder(stack, surfaces, settings, ctx).run();
}

}  // namespace voidpath::toolpath
