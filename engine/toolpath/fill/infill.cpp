#include "engine/toolpath/fill/infill.h"

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/bead.h"
#include "engine/toolpath/fill/hatch.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using std::numbers::pi;

/// Solid lines are joined along the border up to this many spacings: a shallow angle between line and
/// border makes the link long, and it lies where the border's bead is short of material anyway.
constexpr double kSolidLinkSpacings = 4.0;
/// Sparse lines are joined up to this many of their own spacings, which covers borders at 45°...
constexpr double kSparseLinkSpacings = 1.5;
/// ...but never further than this, mm: a link costs material that the density does not ask for.
constexpr double kMaxSparseLinkMm = 8.0;
/// Length of the gyroid's cut per area, times its period, averaged over height: surface per volume of the
/// gyroid (3.0919 per period) times the mean of |sin| over directions (π/4).
constexpr double kGyroidLengthDensity = 3.0919 * pi / 4.0;
constexpr int kGyroidStepsPerPeriod = 24;
/// Lines shorter than this stick to nothing, mm.
constexpr double kMinLineMm = 0.3;

FillLines lattice(const geom::Region& domain, double angle, double spacing, double bead_spacing) {
  const double link = std::min(kSparseLinkSpacings * spacing, std::max(kMaxSparseLinkMm, bead_spacing));
  return {hatch({domain}, {angle, spacing, false, link}).lines, false, bead_spacing};
}

FillLines concentric(const geom::Region& domain, double spacing, double bead_spacing) {
  FillLines out{{}, true, bead_spacing};
  geom::Regions rest{domain};
  while (!rest.empty()) {
    for (auto& ring : geom::rings_of(rest)) out.lines.push_back(std::move(ring));
    rest = geom::offset(rest, -from_mm(spacing));
  }
  return out;
}

FillLines gyroid(const geom::Region& domain, double z, double period, double bead_spacing) {
  FillLines out{{}, false, bead_spacing};
  const auto box = geom::bounds(domain.outer);
  if (!box) return out;
  const geom::AreaGrid grid(geom::Regions{domain});
  for (const auto& line : gyroid_lines(*box, z, period))
    for (auto& piece : grid.split(line))
      if (piece.inside && geom::length(piece.points) >= kMinLineMm * geom::kNmPerMm)
        out.lines.push_back(std::move(piece.points));
  return out;
}

}  // namespace

geom::Regions centre_line_area(const geom::Regions& area, const BeadSize& bead, double overlap) {
  const double inset = 0.5 * bead.spacing_mm() - overlap * bead.width_mm;
  return inset == 0 ? area : geom::offset(area, -from_mm(inset));
}

double fill_overlap(const SliceSettings& settings, const BeadSize& bead) {
  if (settings.perimeters > 0) return settings.infill_overlap;
  return 0.5 * (bead.spacing_mm() / bead.width_mm - 1);
}

FillLines solid_fill(const geom::Region& domain, double angle_rad, const BeadSize& bead) {
  const double spacing = bead.spacing_mm();
  Hatch h = hatch({domain}, {angle_rad, spacing, true, kSolidLinkSpacings * spacing});
  return {std::move(h.lines), false, h.spacing_mm};
}

FillLines sparse_fill(const geom::Region& domain, const SliceSettings& settings, double angle,
                      const slice::LayerSpan& span, const BeadSize& bead) {
  const double line = bead.spacing_mm();
  const double density = std::clamp(settings.infill_density, 0.0, 1.0);
  if (density <= 0) return {};
  // At changing heights, lines meet from layer to layer only if their distance stays the same.
  const double apart =
      (settings.adaptive_layers ? bead_spacing_mm(settings.line_width_mm, settings.layer_height_mm) : line) /
      density;
  switch (settings.infill_pattern) {
    case InfillPattern::rectilinear:
      return lattice(domain, angle, apart, line);
    case InfillPattern::grid: {
      FillLines out = lattice(domain, angle, 2 * apart, line);
      FillLines across = lattice(domain, angle + pi / 2, 2 * apart, line);
      out.lines.insert(out.lines.end(), std::make_move_iterator(across.lines.begin()),
                       std::make_move_iterator(across.lines.end()));
      return out;
    }
    case InfillPattern::concentric:
      return concentric(domain, apart, line);
    case InfillPattern::gyroid:
      return gyroid(domain, span.cut_mm(), kGyroidLengthDensity * apart, line);
    case InfillPattern::lightning:
      break;
  }
  return {};
}

/// sin x cos y + sin y cos z + sin z cos x = 0. At fixed z and x this is A sin(y + φ) = c, solved by
/// y = -φ + nπ + (-1)^n asin(c / A) for every n, continuous in x as long as cos² z ≥ ½; otherwise the same
/// equation is solved for x along y.
geom::Polylines gyroid_lines(const geom::Box& box, double z_mm, double period_mm) {
  const double unit = 2 * pi / period_mm;  // radians per mm
  const double sz = std::sin(z_mm * unit);
  const double cz = std::cos(z_mm * unit);
  const bool along_x = cz * cz >= sz * sz;
  auto radians = [&](geom::Coord c) { return geom::to_mm(c) * unit; };
  const double u0 = radians(along_x ? box.min.x : box.min.y);
  const double u1 = radians(along_x ? box.max.x : box.max.y);
  const double v0 = radians(along_x ? box.min.y : box.min.x);
  const double v1 = radians(along_x ? box.max.y : box.max.x);
  // Samples lie on a lattice of their own, so that layers and regions meet.
  const double step = 2 * pi / kGyroidStepsPerPeriod;
  const auto first = static_cast<long>(std::floor(u0 / step));
  const auto last = static_cast<long>(std::ceil(u1 / step));

  auto across = [&](double u, long n) {
    // Along x the equation is taken with the sign that makes q positive: the phase has no jump then.
    const double sign = along_x && cz < 0 ? -1.0 : 1.0;
    const double p = sign * (along_x ? std::sin(u) : sz);
    const double q = sign * (along_x ? cz : std::cos(u));
    const double c = sign * (along_x ? -sz * std::cos(u) : -std::sin(u) * cz);
    const double phase = std::atan2(p, q);
    const double bend = std::asin(std::clamp(c / std::hypot(p, q), -1.0, 1.0));
    return -phase + static_cast<double>(n) * pi + (n % 2 == 0 ? bend : -bend);
  };
  geom::Polylines out;
  const auto n0 = static_cast<long>(std::floor(v0 / pi)) - 2;
  const auto n1 = static_cast<long>(std::ceil(v1 / pi)) + 2;
  for (long n = n0; n <= n1; ++n) {
    geom::Polyline line;
    bool meets = false;
    for (long i = first; i <= last; ++i) {
      const double u = static_cast<double>(i) * step;
      const double v = across(u, n);
      meets = meets || (v >= v0 && v <= v1);
      const geom::Coord a = from_mm(u / unit);
      const geom::Coord b = from_mm(v / unit);
      line.push_back(along_x ? geom::Point{a, b} : geom::Point{b, a});
    }
    if (meets && line.size() > 1) out.push_back(std::move(line));
  }
  return out;
}

}  // namespace voidpath::toolpath
