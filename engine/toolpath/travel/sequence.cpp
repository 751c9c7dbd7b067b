#include "engine/toolpath/travel/sequence.h"

#include "engine/run/parallel_for.h"
#include "engine/toolpath/travel/order.h"

#include <algorithm>
#include <iterator>

namespace voidpath::toolpath {

namespace {

using geom::Point;

/// Layers of more islands than this are ordered in one way only.
constexpr std::size_t kMaxTried = 60;
/// Layers of so few islands and lines of support are ordered sooner than a thread starts.
constexpr std::size_t kQuicklyOrdered = 30;

const Point& end_of(const Path& path) { return path.closed ? path.points.front() : path.points.back(); }

Stop stop_of(const Path& path) {
  if (path.closed) return loop_stop(path.points);
  return {path.points.front(), path.points.back(), true};
}

/// An island is left somewhere else than it is entered, and nobody knows where before it is printed. It
/// counts as a loop along its first wall, or as its middle.
Stop stop_of(const IslandDraft& island, bool as_loop) {
  if (island.walls.empty()) return island.fills.empty() ? Stop{} : stop_of(island.fills.front());
  const geom::Ring& ring = island.walls.front().front().ring;
  if (as_loop) return loop_stop(ring);
  const auto box = geom::bounds(ring);
  if (!box) return {};
  const Point p{(box->min.x + box->max.x) / 2, (box->min.y + box->max.y) / 2};
  return {p, p, true, {}};
}

double travel_of(const std::vector<Path>& paths, Point at) {
  double sum = 0;
  for (const Path& p : paths) {
    sum += geom::distance(at, p.points.front());
    at = end_of(p);
  }
  return sum;
}

}  // namespace

Sequencer::Sequencer(const PrintSettings& settings, const run::Context& ctx)
    : settings_(settings), ctx_(&ctx), seams_(settings.slice.seam) {
  // A print begins at the bed's front left corner, where start G-code tends to prime.
  if (settings.machine.origin_at_centre)
    at_ = {-geom::from_mm(settings.machine.bed_mm[0] / 2), -geom::from_mm(settings.machine.bed_mm[1] / 2)};
}

void Sequencer::print(Path&& path) {
  at_ = end_of(path);
  out_.push_back(std::move(path));
}

void Sequencer::print_fill(Path&& path, const Visit& visit) {
  if (visit.reversed) std::reverse(path.points.begin(), path.points.end());
  if (path.closed) path.points = start_at(path.points, nearest_vertex(path.points, visit.in));
  print(std::move(path));
}

void Sequencer::print_any(std::vector<Path>&& paths) {
  std::vector<Stop> stops;
  stops.reserve(paths.size());
  for (const Path& p : paths) stops.push_back(stop_of(p));
  for (const Visit& v : order_stops(stops, at_)) print_fill(std::move(paths[v.index]), v);
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
  std::vector<Stop> stops;
  stops.reserve(island.walls.size());
  for (const Wall& wall : island.walls) stops.push_back(loop_stop(wall.front().ring));
  for (const Visit& v : order_stops(stops, at_)) print_wall(std::move(island.walls[v.index]), bead);
  print_any(std::move(island.fills));
}

std::vector<Path> Sequencer::order_islands(LayerDraft&& draft, const BeadSize& bead, bool as_loops) {
  out_.clear();
  seams_.begin_layer();
  // Loops in the order given, then what is open in any.
  const auto open =
      std::stable_partition(draft.around.begin(), draft.around.end(), [](const Path& p) { return p.closed; });
  std::vector<Path> ears(std::make_move_iterator(open), std::make_move_iterator(draft.around.end()));
  draft.around.erase(open, draft.around.end());
  for (Path& p : draft.around) print_fill(std::move(p), Visit{0, false, at_});
  print_any(std::move(ears));
  std::vector<Stop> stops;
  for (const auto& island : draft.islands) stops.push_back(stop_of(island, as_loops));
  for (Path& p : draft.support) stops.push_back(stop_of(p));
  const std::size_t islands = draft.islands.size();
  for (const Visit& v : order_stops(stops, at_)) {
    if (v.index < islands)
      print_island(std::move(draft.islands[v.index]), bead);
    else
      print_fill(std::move(draft.support[v.index - islands]), v);
  }
  return std::move(out_);
}

std::vector<Path> Sequencer::order(LayerDraft&& draft, const BeadSize& bead) {
  if (draft.islands.size() < 2 || draft.islands.size() > kMaxTried)
    return order_islands(std::move(draft), bead, false);
  const Point from = at_;
  Sequencer other(*this);
  LayerDraft copy(draft);
  std::vector<Path> by_loops, by_middles;
  const auto one = [&](std::size_t way) {
    if (way == 0)
      by_middles = order_islands(std::move(draft), bead, false);
    else
      by_loops = other.order_islands(std::move(copy), bead, true);
  };
  if (draft.islands.size() + draft.support.size() > kQuicklyOrdered) {
    run::parallel_for(*ctx_, 2, one);
  } else {
    one(0);
    one(1);
  }
  if (travel_of(by_loops, from) >= travel_of(by_middles, from)) return by_middles;
  seams_ = std::move(other.seams_);
  at_ = other.at_;
  return by_loops;
}

}  // namespace voidpath::toolpath
