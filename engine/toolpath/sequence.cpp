#include "engine/toolpath/sequence.h"

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/order.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <limits>

namespace voidpath::toolpath {

namespace {

using geom::Point;

/// A bead is carried when at least this share of its width lies on the layer below.
constexpr double kCarriedShare = 0.5;
/// Overhanging stretches shorter than this stay part of their wall, mm.
constexpr double kMinOverhangMm = 0.5;

const Point& end_of(const Path& path) { return path.closed ? path.points.front() : path.points.back(); }

Point middle(const geom::Box& box) { return {(box.min.x + box.max.x) / 2, (box.min.y + box.max.y) / 2}; }

Stop stop_of(const Path& path) {
  if (path.closed) return {path.points.front(), path.points.front(), false};
  return {path.points.front(), path.points.back(), true};
}

/// Where an island is, for the order of islands.
Stop stop_of(const IslandDraft& island) {
  Point p{};
  if (!island.walls.empty()) {
    if (const auto box = geom::bounds(island.walls.front().front().ring)) p = middle(*box);
  } else if (!island.fills.empty()) {
    p = island.fills.front().points.front();
  }
  return {p, p, true};
}

/// Stretches that are too short join the one before them.
std::vector<geom::Piece> merge_short(std::vector<geom::Piece>&& pieces) {
  std::vector<geom::Piece> out;
  for (auto& piece : pieces) {
    const bool is_short = geom::length(piece.points) < kMinOverhangMm * geom::kNmPerMm;
    if (!out.empty() && (is_short || out.back().inside == piece.inside)) {
      out.back().points.insert(out.back().points.end(), piece.points.begin() + 1, piece.points.end());
    } else {
      out.push_back(std::move(piece));
    }
  }
  return out;
}

}  // namespace

Sequencer::Sequencer(const PrintSettings& settings) : settings_(settings), seams_(settings.slice.seam) {
  // A print begins at the bed's front left corner, where start G-code tends to prime.
  if (settings.machine.origin_at_centre)
    at_ = {-geom::from_mm(settings.machine.bed_mm[0] / 2), -geom::from_mm(settings.machine.bed_mm[1] / 2)};
}

void Sequencer::print(Path&& path) {
  at_ = end_of(path);
  out_.push_back(std::move(path));
}

void Sequencer::print_fill(Path&& path, bool reversed) {
  if (reversed) std::reverse(path.points.begin(), path.points.end());
  if (path.closed) path.points = start_at(path.points, nearest_vertex(path.points, at_));
  print(std::move(path));
}

void Sequencer::print_any(std::vector<Path>&& paths) {
  std::vector<Stop> stops;
  stops.reserve(paths.size());
  for (Path& p : paths) {
    if (p.closed) p.points = start_at(p.points, nearest_vertex(p.points, at_));
    stops.push_back(stop_of(p));
  }
  for (const Visit& v : order_stops(stops, at_)) print_fill(std::move(paths[v.index]), v.reversed);
}

void Sequencer::print_wall(Wall&& wall, const BeadSize& bead) {
  // Inner loops begin beside the seam of the external one, so that the wall is printed without detours.
  const std::size_t seam = seams_.choose(wall.front().ring, at_);
  const Point seam_point = wall.front().ring[seam];
  std::vector<Path> loops;
  for (Loop& loop : wall) {
    const bool external = loop.depth == 0;
    Path path;
    path.role = external ? Role::external_perimeter : Role::perimeter;
    path.points = start_at(loop.ring, external ? seam : nearest_vertex(loop.ring, seam_point));
    path.closed = true;
    path.width_mm = bead.width_mm;
    path.height_mm = bead.height_mm;
    path.area_mm2 = bead.area_mm2();
    loops.push_back(std::move(path));
  }
  if (!settings_.slice.external_perimeters_first) std::reverse(loops.begin(), loops.end());
  for (Path& p : loops) print(std::move(p));
}

void Sequencer::print_island(IslandDraft&& island, const BeadSize& bead) {
  std::vector<Wall>& walls = island.walls;
  while (!walls.empty()) {
    std::size_t best = 0;
    double best_d = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < walls.size(); ++i) {
      const geom::Ring& ring = walls[i].front().ring;
      const double d = geom::distance(ring[nearest_vertex(ring, at_)], at_);
      if (d < best_d) best_d = d, best = i;
    }
    Wall wall = std::move(walls[best]);
    walls.erase(walls.begin() + static_cast<std::ptrdiff_t>(best));
    print_wall(std::move(wall), bead);
  }
  print_any(std::move(island.fills));
}

std::vector<Path> Sequencer::order(LayerDraft&& draft, const BeadSize& bead) {
  out_.clear();
  seams_.begin_layer();
  for (Path& p : draft.around) {
    p.points = start_at(p.points, nearest_vertex(p.points, at_));
    print(std::move(p));
  }
  std::vector<Stop> stops;
  for (const auto& island : draft.islands) stops.push_back(stop_of(island));
  for (Path& p : draft.support) stops.push_back(stop_of(p));
  const std::size_t islands = draft.islands.size();
  for (const Visit& v : order_stops(stops, at_)) {
    if (v.index < islands)
      print_island(std::move(draft.islands[v.index]), bead);
    else
      print_fill(std::move(draft.support[v.index - islands]), v.reversed);
  }
  return std::move(out_);
}

void mark_overhangs(std::vector<Path>& paths, const geom::Regions& own, const geom::Regions& below,
                    double width_mm) {
  if (own == below) return;
  const geom::Regions carried = geom::offset(below, geom::from_mm((1.0 - kCarriedShare) * 0.5 * width_mm));
  const geom::Regions hanging = quick_subtract(own, carried);
  if (hanging.empty()) return;
  const geom::Box box = grown(*geom::bounds(hanging), geom::from_mm(width_mm));
  const geom::AreaGrid grid(carried);
  std::vector<Path> out;
  for (Path& path : paths) {
    const auto own_box = geom::bounds(path.points);
    const bool wall = path.role == Role::external_perimeter || path.role == Role::perimeter;
    if (!wall || !own_box || !overlap(*own_box, box)) {
      out.push_back(std::move(path));
      continue;
    }
    geom::Polyline line = path.points;
    if (path.closed) line.push_back(line.front());
    std::vector<geom::Piece> pieces = merge_short(grid.split(line));
    if (pieces.size() <= 1) {
      if (!pieces.empty() && !pieces.front().inside) path.role = Role::overhang_perimeter;
      out.push_back(std::move(path));
      continue;
    }
    for (geom::Piece& piece : pieces) {
      Path part = path;
      part.closed = false;
      part.points = std::move(piece.points);
      if (!piece.inside) part.role = Role::overhang_perimeter;
      out.push_back(std::move(part));
    }
  }
  paths = std::move(out);
}

}  // namespace voidpath::toolpath
