#include "engine/pipeline/time_candidates.h"

#include "engine/orient/words.h"
#include "engine/pipeline/baselines.h"
#include "engine/pipeline/next_candidates.h"
#include "engine/pipeline/slice_part.h"
#include "engine/run/parallel_for.h"

#include <algorithm>
#include <cmath>
#include <mutex>

namespace voidpath::pipeline {

namespace {

using orient::Candidate;
using orient::Choice;
using orient::Origin;

constexpr std::size_t kRestingBaselines = 4;
/// Candidates timed between two looks at what the times tell.
constexpr std::size_t kWave = 4;

/// What is left of the budget. Clock of the caller; any thread.
class Budget {
 public:
  explicit Budget(const PrepareOptions& options)
      : now_s_(options.now_s), budget_s_(options.budget_s), began_(now_s_ ? now_s_() : 0) {}

  double spent() const { return now_s_ ? now_s_() - began_ : 0; }
  /// A slicing that takes as long as those before it took on average can still end in time.
  bool has_room() const {
    if (!now_s_) return true;
    const std::lock_guard lock(mutex_);
    return spent() + (slicings_ > 0 ? slicing_s_ / slicings_ : 0) < budget_s_;
  }
  void took(double seconds) {
    const std::lock_guard lock(mutex_);
    slicing_s_ += seconds;
    ++slicings_;
  }
  double fraction() const { return budget_s_ > 0 ? std::min(1.0, spent() / budget_s_) : 1; }

 private:
  const std::function<double()>& now_s_;
  double budget_s_;
  double began_;
  mutable std::mutex mutex_;
  double slicing_s_ = 0;
  int slicings_ = 0;
};

/// One candidate a thread: whole slicings side by side waste less than one slicing on all threads. Those
/// timed already are passed over; with `bounded`, those for which the budget has no room left.
void time_all(const mesh::TriangleMesh& mesh, const PrepareOptions& options, Choice& choice,
              const std::vector<std::size_t>& which, Budget& budget, bool bounded, const run::Context& ctx) {
  run::Context inner = ctx;
  inner.threads = 1;
  inner.on_progress = nullptr;
  run::parallel_for(ctx, which.size(), [&](std::size_t i) {
    Candidate& c = choice.candidates[which[i]];
    if (c.predicted_s || (bounded && !budget.has_room())) return;
    const double began = budget.spent();
    try {
      c.predicted_s = time_part(mesh, c.direction, options, inner);
    } catch (const Refused& e) {
      c.printable = false;
      c.why = e.what();
    }
    budget.took(budget.spent() - began);
  });
}

std::string duration(double seconds) {
  const long minutes = std::lround(seconds / 60);
  if (minutes < 2) return orient::number(seconds, 0) + " s";
  if (minutes < 60) return std::to_string(minutes) + " min";
  return std::to_string(minutes / 60) + " h " + (minutes % 60 < 10 ? "0" : "") +
         std::to_string(minutes % 60) + " min";
}

std::string explain(const Choice& choice, const std::string& by_criteria) {
  const Candidate& c = choice.candidates[choice.chosen];
  const Candidate& d = choice.candidates[choice.as_delivered];
  if (choice.chosen == choice.as_delivered) return "as delivered prints fastest of all that were timed";
  if (!d.predicted_s || !c.predicted_s) return by_criteria;
  const double saved = *d.predicted_s - *c.predicted_s;
  return duration(*c.predicted_s) + " instead of " + duration(*d.predicted_s) + " (" +
         orient::number(100 * saved / *d.predicted_s, 0) + " % less): " + by_criteria;
}

/// A part that does not stand as it came was no candidate; what turning it saves is told all the same.
void time_as_delivered(const mesh::TriangleMesh& mesh, const PrepareOptions& options, Choice& choice,
                       const run::Context& ctx) {
  Candidate& d = choice.candidates[choice.as_delivered];
  if (d.predicted_s) return;
  try {
    d.predicted_s = time_part(mesh, d.direction, held(options, d), ctx);
  } catch (const Refused&) {
    // It does not fit: there is nothing to compare with.
  }
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
                     const run::Context& ctx) {
  if (!choice.candidates[choice.chosen].printable) return;  // nothing stands: nothing to compare
  Budget budget(options);
  const std::vector<Underside> under = undersides_of(mesh, choice, options, ctx);
  choice.baselines = find_baselines(choice);
  if (const auto i = least_overhang(choice, under, mesh::surface_area(mesh)))
    choice.baselines.emplace("least overhang", *i);

  std::vector<std::size_t> wave;
  for (const auto& [name, i] : choice.baselines)
    if (std::find(wave.begin(), wave.end(), i) == wave.end()) wave.push_back(i);
  ctx.progress("time", 0);
  time_all(mesh, options, choice, wave, budget, false, ctx);

  std::size_t left = options.max_extra.value_or(options.now_s ? choice.candidates.size() : 0);
  const NextCandidates queue(choice, under);
  while (left > 0 && budget.has_room()) {
    ctx.progress("time", budget.fraction());
    wave = queue.next(std::min(left, kWave));
    if (wave.empty()) break;
    left -= wave.size();
    time_all(mesh, options, choice, wave, budget, true, ctx);
  }

  const auto time_of = [&](std::size_t i) { return choice.candidates[i].predicted_s.value_or(1e300); };
  std::size_t best = choice.chosen;
  for (std::size_t i = 0; i < choice.candidates.size(); ++i) {
    const bool quicker =
        time_of(i) < time_of(best) ||
        (time_of(i) == time_of(best) && choice.candidates[i].score < choice.candidates[best].score);
    if (choice.candidates[i].printable && quicker) best = i;
  }
  // Of equals, the part as it came.
  if (choice.candidates[choice.as_delivered].printable && time_of(choice.as_delivered) <= time_of(best)) best = choice.as_delivered;
  choice.chosen = best;
  choice.ties.clear();
  for (std::size_t i = 0; i < choice.candidates.size(); ++i)
    if (choice.candidates[i].printable && time_of(i) == time_of(best)) choice.ties.push_back(i);
  time_as_delivered(mesh, options, choice, ctx);
  choice.why = explain(choice, orient::explain(choice));
}

}  // namespace voidpath::pipeline
