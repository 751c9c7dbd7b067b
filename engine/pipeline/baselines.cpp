#include "engine/pipeline/baselines.h"

#include "engine/orient/score.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace voidpath::pipeline {

namespace {

using orient::Candidate;
using orient::Choice;

/// Heights this near are equal: a hundredth of a layer. mm
constexpr double kSameHeight_mm = 1e-3;
/// Trapped volumes this near are equal: nobody sees a cubic millimetre, and rounding is far below.
constexpr double kSameTrapped_mm3 = 1;
/// Unprintabilities this near, as a share, are equal: rounding of sums over facets.
constexpr double kSameUnprintability = 1e-9;

/// The first of those least by `value`, up to `tolerance`, the part as it came before all others.
template <class Value>
std::optional<std::size_t> first_of_least(const Choice& choice, const std::vector<std::size_t>& among,
                                          Value value, double tolerance) {
  double least = std::numeric_limits<double>::infinity();
  for (const std::size_t i : among) least = std::min(least, value(i));
  std::optional<std::size_t> best;
  const auto rank = [&](std::size_t i) {
    return std::tuple(!choice.candidates[i].printable, i != choice.as_delivered);
  };
  for (const std::size_t i : among)
    if (value(i) <= least + tolerance && (!best || rank(i) < rank(*best))) best = i;
  return best;
}

std::vector<std::size_t> printable(const Choice& choice) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < choice.candidates.size(); ++i)
    if (choice.candidates[i].printable) out.push_back(i);
  return out;
}

}  // namespace

std::optional<std::size_t> score_winner(const Choice& choice, const orient::Weights& weights, Only only,
                                        double tie_tolerance) {
  std::vector<Candidate> published;
  std::vector<std::size_t> index;
  for (std::size_t i = 0; i < choice.candidates.size(); ++i) {
    if (choice.candidates[i].origin == orient::Origin::resting_face) continue;
    published.push_back(choice.candidates[i]);
    index.push_back(i);
  }
  orient::score(published, weights);
  std::vector<double> scores(choice.candidates.size());
  std::vector<std::size_t> among;
  for (std::size_t k = 0; k < published.size(); ++k) {
    scores[index[k]] = published[k].score;
    if (only == Only::any || published[k].printable) among.push_back(index[k]);
  }
  return first_of_least(
      choice, among, [&](std::size_t i) { return scores[i]; }, tie_tolerance);
}

std::optional<std::size_t> lowest(const Choice& choice) {
  const auto criteria = [&](std::size_t i) -> const orient::Criteria& {
    return choice.candidates[i].criteria;
  };
  std::vector<std::size_t> among = printable(choice);
  double height = std::numeric_limits<double>::infinity();
  for (const std::size_t i : among) height = std::min(height, criteria(i).height_mm);
  std::erase_if(among, [&](std::size_t i) { return criteria(i).height_mm > height + kSameHeight_mm; });
  return first_of_least(
      choice, among, [&](std::size_t i) { return criteria(i).trapped_mm3; }, kSameTrapped_mm3);
}

std::optional<std::size_t> least_overhang(const Choice& choice, const std::vector<Underside>& under,
                                          double surface_mm2) {
  const std::vector<std::size_t> among = printable(choice);
  return first_of_least(
      choice, among, [&](std::size_t i) { return unprintability(under[i], surface_mm2); },
      kSameUnprintability);
}

std::vector<Underside> undersides_of(const mesh::TriangleMesh& mesh, const Choice& choice,
                                     const PrepareOptions& options, const run::Context& ctx) {
  std::vector<geom::Vec3> directions;
  for (const Candidate& c : choice.candidates) directions.push_back(c.direction);
  UndersideOptions under;
  under.overhang_deg = options.print.slice.support_angle_deg;
  under.contact_depth_mm = options.orient.limits.contact_depth_mm;
  return undersides(mesh, directions, under, ctx);
}

std::string axis_name(const geom::Vec3& d) {
  int axis = 0;
  d.cwiseAbs().maxCoeff(&axis);
  return std::string("axis ") + (d[axis] > 0 ? '+' : '-') + "xyz"[axis];
}

}  // namespace voidpath::pipeline
