#include "engine/toolpath/fill/fill_directions.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/fill/hatch.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace voidpath::toolpath {

namespace {

using std::numbers::pi;

/// Directions tried: every 15°. The first six and the last six are at right angles.
constexpr std::size_t kDirections = 12;
/// Directions of solid layers on top of one another differ by this many of them at least: 45°.
constexpr std::size_t kLeastTurn = 3;
/// Lines judged by are this many spacings apart...
constexpr double kProbeSpacings = 8.0;
/// ...but this many lie across an area at least,
constexpr double kProbesAcross = 6.0;
/// unless they came closer than this many spacings: a sliver of a nanometre would ask for millions of them.
constexpr double kLeastProbeSpacings = 0.5;
/// Without an acceleration in the settings the printer's own counts; this stands for it, mm/s².
constexpr double kUsualAcceleration = 1000.0;

using Seconds = std::array<double, kDirections>;

double angle_of(std::size_t k) { return static_cast<double>(k) * pi / kDirections; }
double turned(double angle, std::size_t index) { return index % 2 == 0 ? angle : angle + pi / 2; }

/// Of one line from rest to rest.
double seconds_of(double length_mm, double v, double a) {
  return length_mm * a >= v * v ? length_mm / v + v / a : 2 * std::sqrt(length_mm / a);
}

struct Costs {
  Seconds solid{};
  Seconds sparse{};
};

Costs costs_of(const Surfaces& s, const PrintSettings& settings, double acceleration) {
  Costs out;
  const double line = settings.slice.line_width_mm;
  const double density = std::clamp(settings.slice.infill_density, 0.01, 1.0);
  for (std::size_t k = 0; k < kDirections; ++k) {
    const double angle = angle_of(k);
    out.solid[k] = seconds_of_lines(s.solid, angle, line, settings.speed.solid_infill, acceleration) +
                   seconds_of_lines(s.top, angle, line, settings.speed.top_solid_infill, acceleration);
    out.sparse[k] = seconds_of_lines(s.sparse, angle, line / density, settings.speed.infill, acceleration);
  }
  return out;
}

std::size_t across(std::size_t k) { return (k + kDirections / 2) % kDirections; }

/// The direction of even layers that is best for all.
std::size_t best_for_part(const std::vector<Costs>& costs, bool with_solid) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::max();
  for (std::size_t k = 0; k < kDirections; ++k) {
    double sum = 0;
    for (std::size_t i = 0; i < costs.size(); ++i) {
      const std::size_t d = i % 2 == 0 ? k : across(k);
      sum += costs[i].sparse[d] + (with_solid ? costs[i].solid[d] : 0.0);
    }
    if (sum < least) least = sum, best = k;
  }
  return best;
}

/// Each layer's direction, crossing the one below, for the least sum.
std::vector<std::size_t> best_for_layers(const std::vector<Costs>& costs) {
  const std::size_t n = costs.size();
  std::vector<Seconds> sum(n);
  std::vector<std::array<std::size_t, kDirections>> from(n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < kDirections; ++k) {
      double least = i == 0 ? 0 : std::numeric_limits<double>::max();
      for (std::size_t turn = kLeastTurn; i > 0 && turn <= kDirections - kLeastTurn; ++turn) {
        const std::size_t before = (k + turn) % kDirections;
        if (sum[i - 1][before] < least) least = sum[i - 1][before], from[i][k] = before;
      }
      sum[i][k] = least + costs[i].solid[k];
    }
  std::vector<std::size_t> out(n);
  if (n == 0) return out;
  out[n - 1] =
      static_cast<std::size_t>(std::min_element(sum[n - 1].begin(), sum[n - 1].end()) - sum[n - 1].begin());
  for (std::size_t i = n - 1; i > 0; --i) out[i - 1] = from[i][out[i]];
  return out;
}

}  // namespace

double seconds_of_lines(const geom::Regions& area, double angle_rad, double spacing_mm, double speed_mm_s,
                        double acceleration_mm_s2) {
  double sum = 0;
  for (const geom::Region& region : area) {
    const auto box = geom::bounds(region.outer);
    if (!box) continue;
    const double size = geom::to_mm(std::min(box->max.x - box->min.x, box->max.y - box->min.y));
    const double probe =
        std::clamp(size / kProbesAcross, kLeastProbeSpacings * spacing_mm, kProbeSpacings * spacing_mm);
    double seconds = 0, length = 0;
    for (const auto& line : hatch({region}, {angle_rad, probe, true, 0}).lines) {
      const double mm = geom::length(line) / geom::kNmPerMm;
      seconds += seconds_of(mm, speed_mm_s, acceleration_mm_s2);
      length += mm;
    }
    // The lines printed add up to the area over their spacing.
    if (length > 0) sum += seconds / length * geom::to_mm2(geom::area(region)) / spacing_mm;
  }
  return sum;
}

std::vector<FillDirections> choose_directions(const std::vector<Surfaces>& surfaces,
                                              const PrintSettings& settings, const run::Context& ctx) {
  const std::size_t n = surfaces.size();
  const SliceSettings& s = settings.slice;
  double base = s.infill_angle_deg * pi / 180.0;
  std::vector<std::size_t> own;
  if (s.infill_direction != InfillDirection::fixed) {
    const double a = settings.acceleration.print > 0 ? settings.acceleration.print : kUsualAcceleration;
    std::vector<Costs> costs(n);
    run::parallel_for(ctx, n, [&](std::size_t i) { costs[i] = costs_of(surfaces[i], settings, a); });
    const bool by_layer = s.infill_direction == InfillDirection::layer;
    base = angle_of(best_for_part(costs, !by_layer));
    if (by_layer) own = best_for_layers(costs);
  }
  std::vector<FillDirections> out(n);
  for (std::size_t i = 0; i < n; ++i) {
    const bool crossing = s.infill_pattern == InfillPattern::rectilinear;
    out[i].solid = own.empty() ? turned(base, i) : angle_of(own[i]);
    out[i].sparse = crossing ? turned(base, i) : base;
    out[i].thick = crossing ? turned(base, surfaces[i].group) : base;
    const bool on_thick = i > 0 && !surfaces[i - 1].thick.empty();
    out[i].over_sparse = turned(base, on_thick ? surfaces[i - 1].group + 1 : i);
  }
  return out;
}

}  // namespace voidpath::toolpath
