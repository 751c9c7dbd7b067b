#include "engine/toolpath/support/support_borders.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/bead.h"
#include "engine/toolpath/bead_area.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
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
/// Caps of which more than this share of their length is bordered already need nothing.
constexpr double kAlreadyBordered = 0.4;
/// Borders of areas of line centres are as exact as offsets are, nm.
constexpr geom::Coord kSlack = 5000;
/// Shorter stretches of border need no line, mm.
constexpr double kLeastCapMm = 0.8;
/// Border further from the last line than this share of their distance is printed: dense lines on which it
/// begins reach no further beyond that line.
constexpr double kCapShare = 0.5;
/// Places for the lines that are tried, and layers they are tried on.
constexpr std::size_t kShifts = 12;
constexpr std::size_t kLooks = 60;
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

/// Lines along x, nm: one goes through y = `shift`.
struct Lines {
  double apart = 0;
  double shift = 0;

  geom::Coord row_of(geom::Coord y) const {
    return static_cast<geom::Coord>(std::floor((static_cast<double>(y) - shift) / apart));
  }
  double line(geom::Coord row) const { return static_cast<double>(row) * apart + shift; }
};

/// Of a stretch of border between two lines: how much of it runs along the lines, too far from the one on
/// its inner side. nm
double unlined(const geom::Polyline& stretch, const Lines& lines) {
  double sum = 0;
  for (std::size_t i = 1; i < stretch.size(); ++i) {
    const geom::Point &a = stretch[i - 1], &b = stretch[i];
    const auto dx = static_cast<double>(b.x - a.x), dy = static_cast<double>(b.y - a.y);
    if (std::abs(dy) > std::abs(dx)) continue;
    // What is to be held lies to the left: above where the border runs along x.
    const geom::Coord y = (a.y + b.y) / 2;
    const double over = static_cast<double>(y) - lines.line(lines.row_of(y));
    if ((dx > 0 ? lines.apart - over : over) > kCapShare * lines.apart) sum += std::abs(dx);
  }
  return sum;
}

/// The border of an area from line to line, piece by piece; `visit` may take them.
template <class Visit>
void each_stretch(const geom::Region& domain, const Lines& lines, Visit&& visit) {
  for (const geom::Ring& ring : geom::rings_of({domain})) {
    // The ring begins after a crossing, or has none.
    std::size_t first = 0;
    const std::size_t n = ring.size();
    while (first < n && lines.row_of(ring[first].y) == lines.row_of(ring[(first + 1) % n].y)) ++first;
    if (first == n) continue;
    geom::Polyline stretch;
    for (std::size_t k = 0; k <= n; ++k) {
      const geom::Point& a = ring[(first + k) % n];
      const geom::Point& b = ring[(first + k + 1) % n];
      if (k > 0) stretch.push_back(a);
      const geom::Coord row_a = lines.row_of(a.y), row_b = lines.row_of(b.y);
      const geom::Coord step = row_b > row_a ? 1 : -1;
      for (geom::Coord row = row_a; row != row_b; row += step) {
        const double y = lines.line(step > 0 ? row + 1 : row);
        const double t = (y - static_cast<double>(a.y)) / static_cast<double>(b.y - a.y);
        const geom::Point p{a.x + std::llround(t * static_cast<double>(b.x - a.x)), std::llround(y)};
        if (!stretch.empty()) {
          stretch.push_back(p);
          visit(std::move(stretch));
        }
        stretch = {p};
        if (k == n) break;  // the first crossing again
      }
    }
  }
}

/// Border of an area of line centres, from line to line, where it runs too far from the last line.
geom::Polylines caps_of(const geom::Region& domain, const Lines& lines) {
  geom::Polylines out;
  each_stretch(domain, lines, [&](geom::Polyline&& stretch) {
    if (unlined(stretch, lines) > kLeastCapMm * geom::kNmPerMm) out.push_back(std::move(stretch));
  });
  return out;
}

/// What a layer below must carry of these borders and does not: where it has no such borders itself.
Regions begun(const Regions& borders, const Regions& below, const SliceSettings& s) {
  if (borders.empty() || borders == below) return {};
  const Regions fresh = quick_subtract(borders, geom::offset(below, from_mm(kBesideShare * s.line_width_mm)));
  return geom::remove_small(geom::open(fresh, from_mm(0.25 * s.line_width_mm)), kMinFloorMm2 * kMm2);
}

double length_of(const geom::Polylines& lines) {
  double sum = 0;
  for (const geom::Polyline& line : lines) sum += geom::length(line);
  return sum;
}

std::size_t field_of(const SupportLattice& lattice, const geom::Point& p) {
  std::size_t f = 0;
  while (f < lattice.fields.size() && !geom::contains(lattice.fields[f].area, p)) ++f;
  return f;
}

double shift_of(std::size_t place, double apart) { return apart * static_cast<double>(place) / kShifts; }

/// What the borders cost with lines at each of the places tried, by field.
using Costs = std::vector<std::array<double, kShifts>>;

Costs costs_of(const Regions& column, const SupportLattice& lattice, double apart, const SliceSettings& s) {
  Costs out(lattice.fields.size());
  for (auto& c : out) c.fill(0);
  for (const auto& domain : geom::offset(column, -from_mm(0.5 * s.line_width_mm))) {
    const std::size_t f = field_of(lattice, domain.outer.front());
    if (f == lattice.fields.size()) continue;
    for (std::size_t k = 0; k < kShifts; ++k)
      for (const geom::Polyline& cap : caps_of(domain, {apart, shift_of(k, apart)}))
        out[f][k] += geom::length(cap);
  }
  return out;
}

}  // namespace

double support_line_distance_mm(const SliceSettings& settings, double density) {
  return line_spacing_mm(settings) / std::clamp(density, 0.01, 1.0);
}

geom::Coord SupportLattice::shift_at(const geom::Point& p) const {
  const std::size_t f = field_of(*this, p);
  return f < fields.size() ? fields[f].shift : 0;
}

std::shared_ptr<const SupportLattice> choose_lattice(const std::vector<Regions>& columns,
                                                     const std::vector<Regions>& contact,
                                                     const SliceSettings& s, const run::Context& ctx) {
  const double apart_mm = support_line_distance_mm(s, s.support_density);
  if (s.support_density <= 0 || apart_mm <= kSparseSpacings * line_spacing_mm(s)) return nullptr;
  const double apart = apart_mm * geom::kNmPerMm;
  auto out = std::make_shared<SupportLattice>();
  geom::Rings rings;
  for (const Regions& c : contact)
    for (geom::Ring& ring : geom::rings_of(c)) rings.push_back(std::move(ring));
  for (auto& area : geom::offset(geom::unite(rings), from_mm(s.line_width_mm)))
    out->fields.push_back({std::move(area), 0});
  std::vector<std::size_t> looked_at;
  const std::size_t every = columns.size() / kLooks + 1;
  for (std::size_t i = 0; i < columns.size(); i += every)
    if (!columns[i].empty()) looked_at.push_back(i);
  std::vector<Costs> costs(looked_at.size());
  run::parallel_for(ctx, looked_at.size(),
                    [&](std::size_t k) { costs[k] = costs_of(columns[looked_at[k]], *out, apart, s); });
  for (std::size_t f = 0; f < out->fields.size(); ++f) {
    double least = std::numeric_limits<double>::max();
    for (std::size_t k = 0; k < kShifts; ++k) {
      double sum = 0;
      for (const Costs& c : costs) sum += c[f][k];
      if (sum >= least) continue;
      least = sum;
      out->fields[f].shift = std::llround(shift_of(k, apart));
    }
  }
  return out;
}

ColumnBorders find_borders(const Regions& column, const SupportLattice& lattice, double line_width_mm,
                           const SliceSettings& s) {
  const double apart_mm = support_line_distance_mm(s, s.support_density), line_mm = line_spacing_mm(s);
  ColumnBorders out;
  for (const auto& domain : geom::offset(column, -from_mm(0.5 * line_width_mm))) {
    const Lines lines{apart_mm * geom::kNmPerMm, static_cast<double>(lattice.shift_at(domain.outer.front()))};
    Regions parts = narrow_parts(domain, apart_mm, line_mm);
    for (geom::Polyline& cap : caps_of(domain, lines))
      if (parts.empty() || length_of(geom::clip_inside({cap}, parts)) <= kAlreadyBordered * geom::length(cap))
        out.caps.push_back(std::move(cap));
    append(out.narrow, quick_intersect(parts, {domain}));
  }
  geom::Polylines plain;
  for (const geom::Polyline& cap : out.caps)
    plain.push_back(geom::simplify(cap, from_mm(kBorderToleranceMm)));
  out.all = quick_unite(bead_area(plain, line_mm * geom::kNmPerMm), out.narrow);
  return out;
}

void border_columns(std::vector<SupportAreas>& areas, const std::vector<Regions>& columns,
                    const std::vector<ColumnBorders>& borders,
                    const std::shared_ptr<const SupportLattice>& lattice, const SliceSettings& s,
                    const run::Context& ctx) {
  const std::size_t n = columns.size();
  const double apart = support_line_distance_mm(s, s.support_density);
  run::parallel_for(ctx, n, [&](std::size_t i) {
    SupportAreas& own = areas[i];
    own.lattice = lattice;
    if (i + 1 < n) {
      const Regions fresh = begun(borders[i + 1].all, borders[i].all, s);
      if (!fresh.empty()) {
        own.floor = quick_intersect(geom::offset(fresh, from_mm(0.5 * apart)), own.sparse);
        own.floor = geom::open(own.floor, from_mm(0.5 * s.line_width_mm));
        own.sparse = geom::open(quick_subtract(own.sparse, own.floor), from_mm(0.5 * s.line_width_mm));
      }
    }
    if (borders[i].all.empty()) return;
    if (i > 0 && own.sparse == columns[i]) {
      own.bordered = borders[i].narrow;
      own.caps = borders[i].caps;
      return;
    }
    const Regions centres = geom::offset(own.sparse, -from_mm(0.5 * s.line_width_mm) + kSlack);
    own.bordered = quick_intersect(borders[i].narrow, centres);
    if (!borders[i].caps.empty() && !centres.empty()) own.caps = geom::clip_inside(borders[i].caps, centres);
  });
}

}  // namespace voidpath::toolpath
