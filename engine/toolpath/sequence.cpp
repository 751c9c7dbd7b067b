#include "engine/toolpath/sequence.h"

#include "engine/toolpath/order.h"

#include <algorithm>
#include <limits>

namespace voidpath::toolpath {

namespace {

using geom::Point;

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
    if (geom::perimeter(path.points) <= settings_.slice.small_perimeter_length_mm * geom::kNmPerMm)
      path.max_speed_mm_s = settings_.speed.small_perimeter;
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

}  // namespace voidpath::toolpath
