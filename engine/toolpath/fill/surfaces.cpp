#include "engine/toolpath/fill/surfaces.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/fill/internal_bridges.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Regions;
using Shared = std::shared_ptr<const Regions>;

/// Steps between layers narrower than this do not count as a surface, mm: noise of slicing.
constexpr double kMinSurfaceMm = 0.05;
/// Bridges reach this far onto the material beside them, mm.
constexpr double kBridgeAnchorMm = 1.2;
/// Neighbouring bridges take what is between them in this many steps.
constexpr int kAnchorSteps = 4;
/// What hangs over air by less than this many widths inside the walls is no bridge: the walls carry it.
constexpr double kMinBridgeWidths = 0.5;
/// Sparse areas narrower than this many widths are filled solid.
constexpr double kMinSparseWidths = 2.0;
/// Heights that differ by less are equal, mm.
constexpr double kSameHeightMm = 1e-6;

/// How many layers above and below each make its shells.
class ShellCounts {
 public:
  ShellCounts(const slice::LayerStack& stack, const SliceSettings& settings)
      : stack_(stack), settings_(settings) {}

  /// A layer is solid while the layers above it up to the surface are thinner than asked.
  std::size_t top(std::size_t i) const {
    if (settings_.top_layers <= 0) return 0;
    const double limit = stack_[i].span.top_mm + settings_.top_thickness_mm - kSameHeightMm;
    std::size_t k = 1;
    while (i + k < stack_.size() && stack_[i + k].span.top_mm < limit) ++k;
    return std::max(k, static_cast<std::size_t>(settings_.top_layers));
  }
  std::size_t bottom(std::size_t i) const {
    if (settings_.bottom_layers <= 0) return 0;
    const double limit = stack_[i].span.bottom_mm - settings_.bottom_thickness_mm + kSameHeightMm;
    std::size_t k = 1;
    while (k <= i && stack_[i - k].span.bottom_mm > limit) ++k;
    return std::max(k, static_cast<std::size_t>(settings_.bottom_layers));
  }
  std::size_t longest() const {
    std::size_t most = 1;
    for (std::size_t i = 0; i < stack_.size(); ++i) most = std::max({most, top(i), bottom(i)});
    return most;
  }

 private:
  const slice::LayerStack& stack_;
  const SliceSettings& settings_;
};

/// Intersections of runs of consecutive layers. `level[k][i]` covers layers i … i + 2^k − 1; any longer run
/// is the intersection of two that overlap.
class Runs {
 public:
  /// Only for what common() is asked for around the layers of which `wanted` is true.
  Runs(const slice::LayerStack& stack, const std::vector<bool>& wanted, const ShellCounts& counts,
       const run::Context& ctx)
      : stack_(stack) {
    const std::size_t n = stack.size();
    const std::size_t longest = counts.longest();
    const auto asked = asked_for(wanted, counts);
    levels_.emplace_back(n);
    for (std::size_t i = 0; i < n; ++i)  // equal neighbours share one copy: comparing them is free
      levels_[0][i] = i > 0 && stack[i].regions == stack[i - 1].regions ? levels_[0][i - 1]
                                                                        : Shared(Shared{}, &stack[i].regions);
    for (std::size_t step = 1; 2 * step <= longest; step *= 2) {
      const auto& shorter = levels_.back();
      const std::vector<bool>& needed = asked[levels_.size()];
      std::vector<Shared> next(n);
      run::parallel_for(ctx, n, [&](std::size_t i) {
        if (needed[i] && i + 2 * step <= n) next[i] = meet(shorter[i], shorter[i + step]);
      });
      levels_.push_back(std::move(next));
    }
  }

  /// What all layers in [first, first + count) have in common; empty beyond the part's ends.
  Shared common(std::ptrdiff_t first, std::size_t count) const {
    if (first < 0 || static_cast<std::size_t>(first) + count > stack_.size())
      return std::make_shared<Regions>();
    const auto i = static_cast<std::size_t>(first);
    const auto level = level_of(count);
    return meet(levels_[level][i], levels_[level][i + count - (std::size_t{1} << level)]);
  }

 private:
  static std::size_t level_of(std::size_t count) {
    return static_cast<std::size_t>(std::bit_width(count) - 1);
  }

  /// By level, which runs common() looks at for the wanted layers, directly or through longer ones.
  static std::vector<std::vector<bool>> asked_for(const std::vector<bool>& wanted,
                                                  const ShellCounts& counts) {
    const std::size_t n = wanted.size();
    std::vector<std::vector<bool>> asked(level_of(counts.longest()) + 1, std::vector<bool>(n));
    const auto ask = [&](std::size_t first, std::size_t count) {
      const std::size_t level = level_of(count);
      asked[level][first] = asked[level][first + count - (std::size_t{1} << level)] = true;
    };
    for (std::size_t i = 0; i < n; ++i) {
      if (!wanted[i]) continue;
      const std::size_t above = counts.top(i);
      const std::size_t below = counts.bottom(i);
      if (above > 0 && i + 1 + above <= n) ask(i + 1, above);
      if (below > 0 && i >= below) ask(i - below, below);
    }
    for (std::size_t level = asked.size(); --level > 0;)
      for (std::size_t i = 0; i < n; ++i)
        if (asked[level][i])
          asked[level - 1][i] = asked[level - 1][i + (std::size_t{1} << (level - 1))] = true;
    return asked;
  }

  static Shared meet(const Shared& a, const Shared& b) {
    return a == b ? a : std::make_shared<Regions>(quick_intersect(*a, *b));
  }
  const slice::LayerStack& stack_;
  std::vector<std::vector<Shared>> levels_;
};

Regions without_noise(const Regions& regions) {
  return regions.empty() ? regions : geom::open(regions, from_mm(0.5 * kMinSurfaceMm));
}

Regions anchored(const Regions& surface, double by_mm, const Regions& within) {
  return surface.empty() ? surface : quick_intersect(geom::offset(surface, from_mm(by_mm)), within);
}

/// Everywhere the region gets to when it is moved along a direction, both ways, by up to `reach_mm`.
Regions swept(const geom::Region& region, double angle_rad, double reach_mm) {
  const double reach = reach_mm * geom::kNmPerMm;
  const geom::Point by{std::llround(reach * std::cos(angle_rad)), std::llround(reach * std::sin(angle_rad))};
  geom::Rings rings;
  const std::size_t n = region.outer.size();
  for (std::size_t i = 0; i < n; ++i) {
    const geom::Point &a = region.outer[i], &b = region.outer[(i + 1) % n];
    geom::Ring strip{{a.x - by.x, a.y - by.y},
                     {b.x - by.x, b.y - by.y},
                     {b.x + by.x, b.y + by.y},
                     {a.x + by.x, a.y + by.y}};
    if (geom::area(strip) < 0) geom::reverse(strip);
    rings.push_back(std::move(strip));
  }
  rings.push_back(region.outer);
  return geom::unite(rings);
}

/// One layer's sorting.
class Sorter {
 public:
  Sorter(const slice::LayerStack& stack, const Runs& runs, const ShellCounts& counts,
         const SliceSettings& settings)
      : stack_(stack), runs_(runs), counts_(counts), settings_(settings) {}

  Surfaces sort(std::size_t i, const Regions& inner) const {
    Surfaces out;
    if (inner.empty()) return out;
    const bool all_solid = settings_.infill_density >= 1.0;
    Regions shells = all_solid ? inner : without_noise(exposed(i, inner));
    if (shells.empty() && !all_solid) {
      out.sparse = inner;
      if (settings_.min_infill_area_mm2 > 0) move_small(out.sparse, out.solid);
      return out;
    }
    const double width = settings_.line_width_mm;
    if (!all_solid) shells = anchored(shells, kSkinAnchorWidths * width, inner);
    Regions bridged;
    if (settings_.bottom_layers > 0) bridged = bridges(i, inner, out.bridges, out.unheld);
    if (settings_.top_layers > 0) {
      const Regions top =
          i + 1 < stack_.size() ? without_noise(quick_subtract(inner, stack_[i + 1].regions)) : inner;
      out.top = quick_subtract(anchored(top, kSkinAnchorWidths * width, inner), bridged);
    }
    const Regions taken = quick_unite(out.top, bridged);
    out.solid = quick_subtract(shells, taken);
    if (!all_solid) out.sparse = quick_subtract(inner, quick_unite(shells, taken));
    tidy(out);
    return out;
  }

 private:
  /// The part of `inner` that lacks one of the layers that would make it inside.
  Regions exposed(std::size_t i, const Regions& inner) const {
    const std::size_t top = counts_.top(i);
    const std::size_t bottom = counts_.bottom(i);
    const auto at = static_cast<std::ptrdiff_t>(i);
    const Shared own = runs_.common(at, 1);  // a neighbour like this layer covers all of it
    Regions out;
    if (top > 0) {
      const Shared above = runs_.common(at + 1, top);
      if (above != own) out = quick_subtract(inner, *above);
    }
    if (bottom > 0) {
      const Shared below = runs_.common(at - static_cast<std::ptrdiff_t>(bottom), bottom);
      if (below != own) out = quick_unite(out, quick_subtract(inner, *below));
    }
    return out;
  }

  Regions bridges(std::size_t i, const Regions& inner, std::vector<BridgeArea>& found,
                  Regions& unheld) const {
    Regions all;
    if (i == 0) return all;
    const double width = settings_.line_width_mm;
    const Regions& below = stack_[i - 1].regions;
    Regions hanging = quick_subtract(inner, below);
    if (hanging.empty()) return all;
    hanging = geom::open(hanging, from_mm(0.5 * kMinBridgeWidths * width));
    const double walls = static_cast<double>(std::max(settings_.perimeters, 0)) * width;
    for (const auto& region : hanging) {
      BridgeArea bridge = plan_bridge(region, below, walls + 0.5 * kBridgeAnchorMm);
      bridge.hanging = region;
      if (!bridge.anchored && settings_.support != SupportMode::none) {
        unheld.push_back(region);
        continue;
      }
      found.push_back(std::move(bridge));
    }
    anchor(found, inner);
    for (BridgeArea& bridge : found) {
      bridge.ground = bridge_ground(below, bridge.area, width);
      all = quick_unite(all, bridge.area);
    }
    return all;
  }

  /// Bridges reach onto the material beside them. Neighbours share it: none takes what another's lines alone
  /// end on, and what is left goes to the nearest.
  void anchor(std::vector<BridgeArea>& found, const Regions& inner) const {
    if (found.size() == 1) found[0].area = anchored({found[0].hanging}, kBridgeAnchorMm, inner);
    if (found.size() <= 1) return;
    std::vector<Regions> held(found.size()), room(found.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      held[k] = swept(found[k].hanging, found[k].angle_rad, kBridgeAnchorMm);
      room[k] = anchored({found[k].hanging}, kBridgeAnchorMm, inner);
    }
    for (std::size_t k = 0; k < found.size(); ++k)
      for (std::size_t j = 0; j < found.size(); ++j)
        if (j != k) room[k] = quick_subtract(room[k], quick_subtract(held[j], held[k]));
    for (int step = 1; step <= kAnchorSteps; ++step)
      for (std::size_t k = 0; k < found.size(); ++k) {
        Regions next = anchored({found[k].hanging}, kBridgeAnchorMm * step / kAnchorSteps, room[k]);
        for (std::size_t j = 0; j < found.size(); ++j)
          if (j != k) next = quick_subtract(next, found[j].area);
        found[k].area = quick_unite(found[k].area, next);
      }
  }

  void move_small(Regions& sparse, Regions& solid) const {
    const double limit = settings_.min_infill_area_mm2 * geom::kNmPerMm * geom::kNmPerMm;
    const auto small = std::stable_partition(sparse.begin(), sparse.end(),
                                             [&](const geom::Region& r) { return geom::area(r) >= limit; });
    solid.insert(solid.end(), small, sparse.end());
    sparse.erase(small, sparse.end());
  }

  /// Sparse remainders too small or too thin for their pattern become solid.
  void tidy(Surfaces& s) const {
    if (s.sparse.empty()) return;
    Regions wide = geom::open(s.sparse, from_mm(0.5 * kMinSparseWidths * settings_.line_width_mm));
    Regions small;
    move_small(wide, small);
    Regions narrow = without_noise(quick_subtract(s.sparse, wide));
    s.sparse = std::move(wide);
    s.solid = quick_unite(s.solid, narrow);
  }

  const slice::LayerStack& stack_;
  const Runs& runs_;
  const ShellCounts& counts_;
  const SliceSettings& settings_;
};

}  // namespace

std::vector<Surfaces> find_surfaces(const slice::LayerStack& stack, const std::vector<Regions>& inner,
                                    const SliceSettings& settings, const run::Context& ctx) {
  const ShellCounts counts(stack, settings);
  std::vector<bool> wanted(stack.size());
  for (std::size_t i = 0; i < stack.size(); ++i) wanted[i] = !inner[i].empty();
  const Runs runs(stack, wanted, counts, ctx);
  const Sorter sorter(stack, runs, counts, settings);
  std::vector<Surfaces> out(stack.size());
  run::parallel_for(ctx, stack.size(), [&](std::size_t i) { out[i] = sorter.sort(i, inner[i]); });
  find_internal_bridges(out, stack, settings, ctx);
  return out;
}

}  // namespace voidpath::toolpath
