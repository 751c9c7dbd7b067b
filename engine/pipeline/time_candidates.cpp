#include "engine/pipeline/time_candidates.h"

#include "engine/orient/words.h"
#include "engine/pipeline/baselines.h"
#include "engine/pipeline/next_candidates.h"
#include "engine/pipeline/refine.h"
#include "engine/pipeline/sample_time.h"
#include "engine/pipeline/trial.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace voidpath::pipeline {

namespace {

using orient::Candidate;
using orient::Choice;
using orient::Origin;

constexpr std::size_t kRestingBaselines = 4;
/// Candidates sampled between two looks at what the times tell.
constexpr std::size_t kWave = 4;
/// How many of the quickest are looked around.
constexpr std::size_t kRefined = 2;
/// A turn about the build axis is worth timing in full when its sample is quicker by this share; the samples
/// of one direction err alike.
constexpr double kTurnGain = 0.003;
/// Of the time left, what sampling the baselines may take.
constexpr double kSamplingShare = 0.6;
/// Of the time left, what timing the part in full as it came may take, where the choice does not need it.
constexpr double kComparisonShare = 0.25;

std::string duration(double seconds) {
  const long minutes = std::lround(seconds / 60);
  if (minutes < 2) return orient::number(seconds, 0) + " s";
  if (minutes < 60) return std::to_string(minutes) + " min";
  return std::to_string(minutes / 60) + " h " + (minutes % 60 < 10 ? "0" : "") +
         std::to_string(minutes % 60) + " min";
}

/// Baselines, once each, that nothing is known of.
std::size_t untold(const Choice& choice, const Trial& trial) {
  std::set<std::size_t> out;
  for (const auto& [name, i] : choice.baselines)
    if (choice.candidates[i].printable && !trial.known(i)) out.insert(i);
  return out.size();
}

std::string explain(const Choice& choice, const Trial& trial, const std::string& by_criteria) {
  const Candidate& c = choice.candidates[choice.chosen];
  const auto chosen_s = trial.known(choice.chosen);
  const auto delivered_s = trial.known(choice.as_delivered);
  const orient::Timing& t = choice.timing;
  std::string out = by_criteria;
  if (choice.chosen == choice.as_delivered) {
    out = "as delivered prints fastest of all that were timed";
  } else if (chosen_s && delivered_s) {
    const bool sampled = !c.predicted_s || !choice.candidates[choice.as_delivered].predicted_s;
    out = (c.predicted_s ? "" : "about ") + duration(*chosen_s) + " instead of " + (sampled ? "about " : "") +
          duration(*delivered_s) + " (" + orient::number(100 * (*delivered_s - *chosen_s) / *delivered_s, 0) +
          " % less): " + by_criteria;
  }
  if (c.turn_rad != 0)
    out += "; turned by " + orient::number(c.turn_rad * 180 / std::numbers::pi, 0) +
           " degrees about the build axis, which prints faster";
  if (!t.complete && t.asked > 0)
    out += "; the time allowed was over before all was settled: " + std::to_string(t.in_full) + " of " +
           std::to_string(t.asked) + " directions timed in full, " + std::to_string(t.sampled) +
           " on a sample of their layers";
  if (const std::size_t n = untold(choice, trial); n > 0)
    out += "; " + std::to_string(n) + " of those it is to beat could not be looked at";
  return out;
}

/// The baselines once each, what a user compares with first: when time is short these are timed at least.
std::vector<std::size_t> in_order(const Choice& choice) {
  std::vector<std::size_t> out{choice.chosen};
  const auto add = [&](std::size_t i) {
    if (choice.candidates[i].printable && std::find(out.begin(), out.end(), i) == out.end()) out.push_back(i);
  };
  add(choice.as_delivered);
  for (const char* name : {"thesis", "lowest", "resting face 1", "ahsan"}) {
    const auto found = choice.baselines.find(name);
    if (found != choice.baselines.end()) add(found->second);
  }
  for (const auto& [name, i] : choice.baselines) add(i);
  return out;
}

/// What turning saves is told by the part as it came, which is timed in full for that where it costs little
/// of the time left, else on a sample of its layers; also where it does not stand so and was no candidate.
void time_as_delivered(const mesh::TriangleMesh& mesh, const PrepareOptions& options, Choice& choice,
                       Trial& trial, const run::Context& ctx) {
  Candidate& d = choice.candidates[choice.as_delivered];
  const Budget& budget = trial.budget();
  const auto affordable = [&](std::size_t like) {
    return !budget.limited() || trial.expected_full_s(like) < kComparisonShare * budget.left();
  };
  if (d.predicted_s) return;
  if (d.printable) {
    if (d.sampled_s && affordable(choice.as_delivered)) trial.time_rest({choice.as_delivered});
    return;
  }
  if (!budget.has_room(trial.expected_sampling_s(1))) return;
  try {
    ended_in_time(budget, ctx, [&](const run::Context& inner) {
      const PrepareOptions how = held(options, d);
      const SampledTime t = sample_time(mesh, d, how, inner);
      (t.planned == t.layers ? d.predicted_s : d.sampled_s) = t.seconds;
      if (const auto best = trial.best(); best && d.sampled_s && affordable(*best))
        d.predicted_s = time_part(mesh, d, how, inner);
    });
  } catch (const Refused&) {
    // It does not fit: there is nothing to compare with.
  }
}

void sample_in_waves(Trial& trial, const std::vector<std::size_t>& which) {
  for (std::size_t k = 0; k < which.size() && !trial.budget_spent(); k += kWave)
    trial.sample({which.begin() + static_cast<std::ptrdiff_t>(k),
                  which.begin() + static_cast<std::ptrdiff_t>(std::min(which.size(), k + kWave))});
}

/// The baselines are all to be looked at, and time is to be left for the quickest of them: when the first
/// ones show that it would not, the others get a shorter look, in a hurry all of them. Returns whether it
/// came to that.
bool sample_baselines(Trial& trial, const std::vector<std::size_t>& baselines, bool hurry,
                      const run::Context& ctx) {
  bool few = hurry;
  std::size_t wave = std::min<std::size_t>(kWave, ctx.thread_count());  // to know soon what one takes
  for (std::size_t k = 0; k < baselines.size() && !trial.budget_spent(); k += wave, wave = kWave) {
    const std::size_t left = baselines.size() - k;
    const Budget& budget = trial.budget();
    few = few || (budget.limited() && trial.expected_sampling_s(left) > kSamplingShare * budget.left());
    trial.sample({baselines.begin() + static_cast<std::ptrdiff_t>(k),
                  baselines.begin() + static_cast<std::ptrdiff_t>(k + std::min(left, wave))},
                 few);
  }
  return few;
}

/// The quickest known, at most `count`, one a direction.
std::vector<std::size_t> leaders(const Choice& choice, const Trial& trial, std::size_t count) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < choice.candidates.size(); ++i)
    if (choice.candidates[i].printable && trial.known(i)) out.push_back(i);
  std::stable_sort(out.begin(), out.end(),
                   [&](std::size_t a, std::size_t b) { return *trial.known(a) < *trial.known(b); });
  out.resize(std::min(out.size(), count));
  return out;
}

void refine(const mesh::TriangleMesh& mesh, const PrepareOptions& options, Choice& choice, Trial& trial,
            const run::Context& ctx) {
  for (const std::size_t i : leaders(choice, trial, kRefined)) {
    if (!trial.budget().has_room(0)) return;
    std::vector<std::size_t> added;
    ended_in_time(trial.budget(), ctx, [&](const run::Context& inner) {
      added = add_neighbours(mesh, choice, i, options, inner);
    });
    sample_in_waves(trial, added);
    trial.settle(added);
  }
  for (const std::size_t i : leaders(choice, trial, kRefined)) {
    if (!trial.budget().has_room(0)) return;
    const auto added = add_turns(choice, i, options);
    sample_in_waves(trial, added);
    // Sample against sample; without samples both times are exact.
    const Candidate base = choice.candidates[i];
    std::optional<std::size_t> quickest;
    for (const std::size_t k : added) {
      const auto& c = choice.candidates[k];
      if (!c.printable || !c.sampled_s || !base.sampled_s) continue;
      if (*c.sampled_s > *base.sampled_s * (1 - kTurnGain)) continue;
      if (!quickest || *c.sampled_s < *choice.candidates[*quickest].sampled_s) quickest = k;
    }
    if (quickest) trial.time_rest({*quickest});
  }
}

void pick(Choice& choice, const Trial& trial) {
  const auto time_of = [&](std::size_t i) { return trial.known(i).value_or(1e300); };
  const auto is_known = [&](const Candidate& c) { return c.predicted_s || c.sampled_s; };
  if (std::none_of(choice.candidates.begin(), choice.candidates.end(), is_known))
    return;  // the score's choice
  std::size_t best = choice.chosen;
  for (std::size_t i = 0; i < choice.candidates.size(); ++i) {
    // Turns are there for their gain: only a full time can show it.
    const bool shown = choice.candidates[i].turn_rad == 0 || choice.candidates[i].predicted_s;
    const bool quicker =
        time_of(i) < time_of(best) ||
        (time_of(i) == time_of(best) && choice.candidates[i].score < choice.candidates[best].score);
    if (choice.candidates[i].printable && shown && quicker) best = i;
  }
  // Of equals, the part as it came.
  if (choice.candidates[choice.as_delivered].printable && time_of(choice.as_delivered) <= time_of(best))
    best = choice.as_delivered;
  choice.chosen = best;
  choice.ties.clear();
  for (std::size_t i = 0; i < choice.candidates.size(); ++i)
    if (choice.candidates[i].printable && time_of(i) == time_of(best)) choice.ties.push_back(i);
  if (choice.ties.empty()) choice.ties.push_back(best);
}

}  // namespace

std::map<std::string, std::size_t> find_baselines(const Choice& choice) {
  std::map<std::string, std::size_t> found;
  const auto add = [&](const std::string& name, std::size_t i) {
    if (choice.candidates[i].printable) found.emplace(name, i);
  };
  add("as-delivered", choice.as_delivered);
  std::size_t resting = 0;
  for (std::size_t i = 0; i < choice.candidates.size(); ++i) {
    const Candidate& c = choice.candidates[i];
    if (c.origin == Origin::axis) add(axis_name(c.direction), i);
    if (c.origin == Origin::resting_face && c.printable && resting < kRestingBaselines)
      add("resting face " + std::to_string(++resting), i);
  }
  const auto add_winner = [&](const char* name, const orient::Weights& weights) {
    if (const auto i = score_winner(choice, weights, Only::printable, orient::SearchOptions().tie_tolerance))
      add(name, *i);
  };
  add_winner("thesis", orient::kThesisWeights);
  add_winner("ahsan", orient::kAhsanWeights);
  if (const auto i = lowest(choice)) add("lowest", *i);
  return found;
}

void time_candidates(const mesh::TriangleMesh& mesh, const PrepareOptions& options, Choice& choice,
                     const run::Context& ctx, bool hurry) {
  if (!choice.candidates[choice.chosen].printable) return;  // nothing stands: nothing to compare
  Trial trial(mesh, options, choice, ctx);
  choice.baselines = find_baselines(choice);
  std::vector<Underside> under;
  if (ended_in_time(trial.budget(), ctx, [&](const run::Context& inner) {
        under = undersides_of(mesh, choice, options, inner);
      })) {
    if (const auto i = least_overhang(choice, under, mesh::surface_area(mesh)))
      choice.baselines.emplace("least overhang", *i);
  } else {
    under.assign(choice.candidates.size(), {});
  }

  ctx.progress("time", 0);
  const std::vector<std::size_t> baselines = in_order(choice);
  std::vector<std::size_t> asked = baselines;
  const bool hurried = sample_baselines(trial, baselines, hurry, ctx);
  bool settled = !trial.budget_spent() && trial.settle(baselines);

  time_as_delivered(mesh, options, choice, trial, ctx);
  std::size_t left = options.max_extra.value_or(options.now_s ? choice.candidates.size() : 0);
  const NextCandidates queue(choice, under, [&](std::size_t i) { return trial.known(i); });
  while (left > 0 && settled && !trial.budget_spent()) {
    const std::vector<std::size_t> wave = queue.next(std::min(left, kWave));
    if (wave.empty()) break;
    left -= wave.size();
    trial.sample(wave);
    asked.insert(asked.end(), wave.begin(), wave.end());
    settled = trial.settle(asked);
  }
  const std::size_t listed = choice.candidates.size();
  if (settled && !trial.budget_spent() && options.max_extra.value_or(1) > 0 &&
      (options.now_s || options.max_extra))
    refine(mesh, options, choice, trial, ctx);
  const bool all_in_full = settled && !trial.budget_spent() && trial.time_rest(baselines);

  for (std::size_t i = listed; i < choice.candidates.size(); ++i) asked.push_back(i);
  orient::Timing& t = choice.timing;
  t = {};
  for (const std::size_t i : asked) {
    const Candidate& c = choice.candidates[i];
    if (!c.printable) continue;
    ++t.asked;
    if (c.predicted_s)
      ++t.in_full;
    else if (c.sampled_s)
      ++t.sampled;
  }
  t.sample_error = trial.sample_error();
  t.complete = settled;
  t.budget_spent = trial.budget_spent() || !all_in_full || hurried;
  pick(choice, trial);
  choice.why = explain(choice, trial, orient::explain(choice));
}

}  // namespace voidpath::pipeline
