#include "engine/toolpath/support_borders.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/bead.h"
#include "engine/toolpath/bead_area.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Regions;

/// Remainders of wide columns smaller than this need no line of their own, mm²: the rest carries them.
constexpr double kMinRestMm2 = 4.0;
/// Borders of columns may be this much plainer than the column, mm.
constexpr double kBorderToleranceMm = 0.1;
/// Lines nearer to one another than this many of their spacings miss nothing that can stand.
constexpr double kSparseSpacings = 2.0;
/// Borders may begin beside those below by this share of a line's width.
constexpr double kBesideShare = 0.5;
/// Pieces of border whose area is smaller than this hold themselves, mm².
constexpr double kMinFloorMm2 = 0.5;
/// Caps of which more than this share is bordered already need nothing.
constexpr double kAlreadyBordered = 0.4;
/// Borders of areas of line centres are as exact as offsets are, nm.
constexpr geom::Coord kSlack = 5000;
/// Shorter stretches of border need no line, mm.
constexpr double kLeastCapMm = 0.8;
/// Border further from the last line than this share of their distance is printed.
constexpr double kCapShare = 0.5;
constexpr double kMm2 = geom::kNmPerMm * geom::kNmPerMm;

double line_spacing_mm(const SliceSettings& s) { return bead_spacing_mm(s.line_width_mm, s.layer_height_mm); }

/// Of an area of line centres, the parts that lines so far apart may miss.
Regions narrow_parts(const geom::Region& area, double apart_mm, double line_mm) {
  const geom::Coord half = from_mm(0.5 * apart_mm);
  const Regions plain = geom::simplify({area}, from_mm(kBorderToleranceMm));
  const Regions core = geom::offset(plain, -half);
  if (core.empty()) return plain;
  const Regions wide = geom::offset(core, half);
  if (geom::area(plain) - geom::area(wide) < kMinRestMm2 * kMm2) return {};
  return geom::remove_small(geom::open(geom::subtract(plain, wide), from_mm(0.5 * line_mm)),
                            kMinRestMm2 * kMm2);
}

geom::Coord row_of(geom::Coord y, double apart) {
  return static_cast<geom::Coord>(std::floor(static_cast<double>(y) / apart));
}

/// Of a stretch of border between two lines: how much of it runs along the lines, further than half of what
/// those are apart from the one on its inner side. nm
double unlined(const geom::Polyline& stretch, double apart) {
  double sum = 0;
  for (std::size_t i = 1; i < stretch.size(); ++i) {
    const geom::Point &a = stretch[i - 1], &b = stretch[i];
    const auto dx = static_cast<double>(b.x - a.x), dy = static_cast<double>(b.y - a.y);
    if (std::abs(dy) > std::abs(dx)) continue;
    // What is to be held lies to the left: above where the border runs along x.
    const double y = 0.5 * static_cast<double>(a.y + b.y);
    const double over = y - std::floor(y / apart) * apart;
    if ((dx > 0 ? apart - over : over) > kCapShare * apart) sum += std::abs(dx);
  }
  return sum;
}

/// Of an area of line centres: its border, from line to line, where it is further from the last line than
/// half a spacing. Lines run along x on a lattice through the plate's origin.
geom::Polylines caps_of(const geom::Region& domain, double apart) {
  geom::Polylines out;
  for (const geom::Ring& ring : geom::rings_of({domain})) {
    // The ring begins after a crossing, or has none.
    std::size_t first = 0;
    const std::size_t n = ring.size();
    while (first < n && row_of(ring[first].y, apart) == row_of(ring[(first + 1) % n].y, apart)) ++first;
    if (first == n) continue;
    geom::Polyline line;
    for (std::size_t k = 0; k <= n; ++k) {
      const geom::Point& a = ring[(first + k) % n];
      const geom::Point& b = ring[(first + k + 1) % n];
      if (k > 0) line.push_back(a);
      const geom::Coord row_a = row_of(a.y, apart), row_b = row_of(b.y, apart);
      const geom::Coord step = row_b > row_a ? 1 : -1;
      for (geom::Coord row = row_a; row != row_b; row += step) {
        const geom::Coord crossed = step > 0 ? row + 1 : row;
        const double y = static_cast<double>(crossed) * apart;
        const double t = (y - static_cast<double>(a.y)) / static_cast<double>(b.y - a.y);
        const geom::Point p{a.x + std::llround(t * static_cast<double>(b.x - a.x)), std::llround(y)};
        if (!line.empty()) {
          line.push_back(p);
          if (unlined(line, apart) > kLeastCapMm * geom::kNmPerMm) out.push_back(std::move(line));
        }
        line = {p};
        if (k == n) break;  // the first crossing again
      }
    }
  }
  return out;
}

/// What a layer below must carry of these borders and does not: where it has no such borders itself.
Regions begun(const Regions& borders, const Regions& below, const SliceSettings& s) {
  if (borders.empty() || borders == below) return {};
  const Regions fresh = quick_subtract(borders, geom::offset(below, from_mm(kBesideShare * s.line_width_mm)));
  return geom::remove_small(geom::open(fresh, from_mm(0.25 * s.line_width_mm)), kMinFloorMm2 * kMm2);
}

/// What of a layer's column gets lines along its border.
struct Borders {
  Regions narrow;        ///< all around
  geom::Polylines caps;  ///< beside the last line
  Regions all;           ///< and where those are

  void add(const geom::Region& domain, double apart_mm, double line_mm) {
    Regions parts = narrow_parts(domain, apart_mm, line_mm);
    for (geom::Polyline& cap : caps_of(domain, apart_mm * geom::kNmPerMm)) {
      const Regions own = bead_area({cap}, line_mm * geom::kNmPerMm);
      if (!parts.empty() && geom::area(quick_intersect(own, parts)) > kAlreadyBordered * geom::area(own))
        continue;
      caps.push_back(std::move(cap));
      all = quick_unite(all, own);
    }
    all = quick_unite(all, parts);
    append(narrow, std::move(parts));
  }
};

}  // namespace

double support_line_distance_mm(const SliceSettings& settings, double density) {
  return line_spacing_mm(settings) / std::clamp(density, 0.01, 1.0);
}

void border_narrow_columns(std::vector<SupportAreas>& areas, const std::vector<Regions>& columns,
                           const SliceSettings& s, const run::Context& ctx) {
  const double apart = support_line_distance_mm(s, s.support_density);
  if (s.support_density <= 0 || apart <= kSparseSpacings * line_spacing_mm(s)) return;
  const std::size_t n = columns.size();
  std::vector<Borders> borders(n);
  run::parallel_for(ctx, n, [&](std::size_t i) {
    if (i > 0 && columns[i] == columns[i - 1]) return;
    const double width = i == 0 ? s.first_layer_line_width_mm : s.line_width_mm;
    for (const auto& domain : geom::offset(columns[i], -from_mm(0.5 * width)))
      borders[i].add(domain, apart, line_spacing_mm(s));
  });
  for (std::size_t i = 1; i < n; ++i)
    if (columns[i] == columns[i - 1]) borders[i] = borders[i - 1];
  run::parallel_for(ctx, n, [&](std::size_t i) {
    SupportAreas& own = areas[i];
    if (i + 1 < n) {
      const Regions fresh = begun(borders[i + 1].all, borders[i].all, s);
      if (!fresh.empty()) {
        own.floor = quick_intersect(geom::offset(fresh, from_mm(0.5 * apart)), own.sparse);
        own.floor = geom::open(own.floor, from_mm(0.5 * s.line_width_mm));
        own.sparse = geom::open(quick_subtract(own.sparse, own.floor), from_mm(0.5 * s.line_width_mm));
      }
    }
    if (borders[i].all.empty()) return;
    const Regions lines = geom::offset(own.sparse, -from_mm(0.5 * s.line_width_mm) + kSlack);
    own.bordered = quick_intersect(borders[i].narrow, lines);
    if (!borders[i].caps.empty() && !lines.empty()) own.caps = geom::clip_inside(borders[i].caps, lines);
  });
}

}  // namespace voidpath::toolpath
