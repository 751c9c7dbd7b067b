#include "engine/orient/evaluate.h"

#include "engine/orient/convex_hull.h"
#include "engine/orient/critical_heights.h"
#include "engine/orient/directions.h"
#include "engine/orient/feasible.h"
#include "engine/run/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <numeric>
#include <tuple>

namespace voidpath::orient {

namespace {

auto as_tuple(const Vec3& v) { return std::tuple(v.x(), v.y(), v.z()); }

std::vector<Index> hull_vertices(const Solid& solid) {
  std::vector<Index> out;
  for (const auto& t : convex_hull(solid.vertices)) out.insert(out.end(), t.begin(), t.end());
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  if (out.empty()) {  // flat
    out.resize(solid.vertices.size());
    std::iota(out.begin(), out.end(), Index{0});
  }
  return out;
}

/// A line through the part and which of the asked directions run along it.
struct Line {
  Vec3 direction;
  std::vector<std::pair<std::size_t, bool>> asked;  ///< index, whether against the line
};

std::vector<Line> lines_of(const std::vector<Vec3>& directions) {
  std::vector<std::size_t> order(directions.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  // + 0.0 turns -0 into 0, which would else tell equal directions apart.
  auto canonical = [&](std::size_t i) {
    const Vec3 d = directions[i].normalized();
    return Vec3((is_canonical(d) ? d : Vec3(-d)) + Vec3::Zero());
  };
  std::vector<Vec3> line(directions.size());
  for (std::size_t i = 0; i < directions.size(); ++i) line[i] = canonical(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return as_tuple(line[a]) < as_tuple(line[b]); });
  std::vector<Line> out;
  for (const std::size_t i : order) {
    if (out.empty() || as_tuple(out.back().direction) != as_tuple(line[i])) out.push_back({line[i], {}});
    out.back().asked.emplace_back(i, !is_canonical(directions[i]));
  }
  return out;
}

}  // namespace

std::array<Evaluation, 2> DirectionEvaluator::evaluate(const Vec3& d) {
  project(solid_, d, projection_);
  const Projection& p = projection_;
  std::array<Evaluation, 2> out;
  auto& [up, down] = out;
  up.criteria.height_mm = down.criteria.height_mm = p.h_max - p.h_min;

  find_slabs(solid_, d, p.h, p.h_min, p.h_max, options_, slabs_);
  sections_.prepare(solid_, p, slabs_);
  fill_.prepare(solid_, p, slabs_);
  for (std::size_t i = 0; i < slabs_.size(); ++i) {
    sections_.trace(i);
    sections_.place();
    const bool told = fill_.settle(i, sections_);
    const SliceMeasure m = told ? regions_.measure_told(sections_.points(), sections_.contours())
                                : regions_.measure(sections_.points(), sections_.contours());
    up.criteria.contours += slabs_[i].weight_up * m.regions;
    up.criteria.void_mm += slabs_[i].weight_up * m.mean_distance_mm;
    down.criteria.contours += slabs_[i].weight_down * m.regions;
    down.criteria.void_mm += slabs_[i].weight_down * m.mean_distance_mm;
  }

  const TrappedVolume v = raster_.measure(p);
  up.criteria.trapped_mm3 = v.up_mm3;
  down.criteria.trapped_mm3 = v.down_mm3;
  up.why_not = why_not_printable(solid_, hull_vertices_, p, End::bottom, options_.limits);
  down.why_not = why_not_printable(solid_, hull_vertices_, p, End::top, options_.limits);
  return out;
}

Evaluation evaluate_standing(const Solid& solid, const Vec3& direction, const PrintLimits& limits) {
  const Line line = lines_of({direction}).front();
  const bool against = line.asked.front().second;
  Projection p;
  project(solid, line.direction, p);
  Evaluation out;
  out.criteria.height_mm = p.h_max - p.h_min;
  out.why_not = why_not_printable(solid, hull_vertices(solid), p, against ? End::top : End::bottom, limits);
  return out;
}

std::vector<Evaluation> evaluate_all(const Solid& solid, const std::vector<Vec3>& directions,
                                     const SearchOptions& options, const run::Context& ctx) {
  const std::vector<Index> hull = hull_vertices(solid);
  const std::vector<Line> lines = lines_of(directions);
  std::vector<Evaluation> out(directions.size());
  std::vector<std::unique_ptr<DirectionEvaluator>> evaluators(ctx.thread_count());
  std::atomic<std::size_t> done{0};
  run::parallel_for_workers(ctx, lines.size(), [&](std::size_t i, unsigned worker) {
    auto& evaluator = evaluators[worker];
    if (!evaluator) evaluator = std::make_unique<DirectionEvaluator>(solid, hull, options);
    const auto both = evaluator->evaluate(lines[i].direction);
    for (const auto& [asked, against] : lines[i].asked) out[asked] = both[against ? 1 : 0];
    ctx.progress("orient", static_cast<double>(++done) / static_cast<double>(lines.size()));
  });
  return out;
}

}  // namespace voidpath::orient
