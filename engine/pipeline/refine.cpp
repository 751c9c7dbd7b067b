#include "engine/pipeline/refine.h"

#include "engine/orient/evaluate.h"
#include "engine/orient/score.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voidpath::pipeline {

namespace {

using geom::Vec3;

constexpr double kDegree = std::numbers::pi / 180;
/// Infill lies at right angles from layer to layer: what a quarter turn adds, the next layer takes away.
constexpr double kTurns_deg[] = {15, 30, 45, 60, 75};
/// Half of the sampled directions' distance from one another, and half of that.
constexpr double kTilts_deg[] = {4, 2};
constexpr int kAround = 6;
/// A direction is looked at already when one is as near as this.
constexpr double kSame_deg = 0.5;

bool axes_alike(const motion::MachineLimits& l) {
  const bool jerk_alike = !l.jerk_mm_s || (*l.jerk_mm_s)[0] == (*l.jerk_mm_s)[1];
  return l.max_speed_mm_s[0] == l.max_speed_mm_s[1] &&
         l.max_acceleration_mm_s2[0] == l.max_acceleration_mm_s2[1] && jerk_alike;
}

}  // namespace

std::vector<std::size_t> add_turns(orient::Choice& choice, std::size_t of, const PrepareOptions& options) {
  std::vector<double> turns(std::begin(kTurns_deg), std::end(kTurns_deg));
  if (!axes_alike(options.limits)) turns.push_back(90);
  std::vector<std::size_t> added;
  for (const double turn : turns) {
    orient::Candidate c = choice.candidates[of];
    c.turn_rad += turn * kDegree;
    c.predicted_s.reset();
    c.sampled_s.reset();
    added.push_back(choice.candidates.size());
    choice.candidates.push_back(std::move(c));
  }
  return added;
}

std::vector<std::size_t> add_neighbours(const mesh::TriangleMesh& mesh, orient::Choice& choice,
                                        std::size_t of, const PrepareOptions& options,
                                        const run::Context& ctx) {
  const Vec3 d = choice.candidates[of].direction;
  const Vec3 e1 = d.unitOrthogonal();
  const Vec3 e2 = d.cross(e1);
  std::vector<Vec3> directions;
  for (const double tilt : kTilts_deg)
    for (int k = 0; k < kAround; ++k) {
      const double a = 2 * std::numbers::pi * k / kAround;
      const Vec3 to =
          (std::cos(tilt * kDegree) * d + std::sin(tilt * kDegree) * (std::cos(a) * e1 + std::sin(a) * e2))
              .normalized();
      const bool is_new = std::none_of(
          choice.candidates.begin(), choice.candidates.end(),
          [&](const orient::Candidate& c) { return c.direction.dot(to) > std::cos(kSame_deg * kDegree); });
      if (is_new) directions.push_back(to);
    }
  std::vector<std::size_t> added;
  if (directions.empty()) return added;
  const auto evaluations =
      orient::evaluate_all(orient::prepare_solid(mesh, ctx), directions, options.orient, ctx);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    if (!evaluations[i].why_not.empty()) continue;
    orient::Candidate c;
    c.direction = directions[i];
    c.origin = orient::Origin::sampled;
    c.criteria = evaluations[i].criteria;
    added.push_back(choice.candidates.size());
    choice.candidates.push_back(std::move(c));
  }
  if (!added.empty()) orient::score(choice.candidates, choice.weights);
  return added;
}

}  // namespace voidpath::pipeline
