#include "engine/pipeline/time_candidates.h"

#include <algorithm>
#include <cmath>

#include "engine/orient/score.h"
#include "engine/orient/words.h"
#include "engine/pipeline/slice_part.h"
#include "engine/run/parallel_for.h"

namespace voidpath::pipeline {

namespace {

using orient::Candidate;
using orient::Choice;
using orient::Origin;

constexpr std::size_t kRestingBaselines = 4;
/// Leaders nearer to one another than this print alike: time the first only. cos of 8°
constexpr double kAlike_cos = 0.990;

std::optional<std::size_t> winner_of(const Choice& choice, const orient::Weights& weights) {
  std::vector<Candidate> sampled;
  std::vector<std::size_t> index;
  for (std::size_t i = 0; i < choice.candidates.size(); ++i) {
    if (choice.candidates[i].origin == Origin::resting_face) continue;
    sampled.push_back(choice.candidates[i]);
    index.push_back(i);
  }
  orient::score(sampled, weights);
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < sampled.size(); ++i)
    if (sampled[i].printable && (!best || sampled[i].score < sampled[*best].score)) best = i;
  if (!best) return std::nullopt;
  return index[*best];
}

std::string axis_name(const geom::Vec3& d) {
  int axis = 0;
  d.cwiseAbs().maxCoeff(&axis);
  return std::string("axis ") + (d[axis] > 0 ? '+' : '-') + "xyz"[axis];
}

/// Best score first, each unlike all before it and all timed already.
std::vector<std::size_t> leaders(const Choice& choice) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < choice.candidates.size(); ++i)
    if (choice.candidates[i].printable && !choice.candidates[i].predicted_s) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return choice.candidates[a].score < choice.candidates[b].score;
  });
  std::vector<geom::Vec3> seen;
  for (const Candidate& c : choice.candidates)
    if (c.predicted_s) seen.push_back(c.direction);
  std::vector<std::size_t> out;
  for (const std::size_t i : order) {
    const Candidate& c = choice.candidates[i];
    // A resting face is never "like" a sampled direction beside it: lying flat is what makes it different.
    const bool alike = c.origin != Origin::resting_face &&
                       std::any_of(seen.begin(), seen.end(),
                                   [&](const geom::Vec3& s) { return s.dot(c.direction) > kAlike_cos; });
    if (alike) continue;
    seen.push_back(c.direction);
    out.push_back(i);
  }
  return out;
}

/// One candidate a thread: whole slicings side by side waste less than one slicing on all threads.
void time_all(const mesh::TriangleMesh& mesh, const PrepareOptions& options, Choice& choice,
              const std::vector<std::size_t>& which, const run::Context& ctx) {
  run::Context inner = ctx;
  inner.threads = 1;
  inner.on_progress = nullptr;
  run::parallel_for(ctx, which.size(), [&](std::size_t i) {
    Candidate& c = choice.candidates[which[i]];
    try {
      c.predicted_s = time_part(mesh, c.direction, options, inner);
    } catch (const Refused& e) {
      c.printable = false;
      c.why = e.what();
    }
  });
}

std::string duration(double seconds) {
  const long minutes = std::lround(seconds / 60);
  if (minutes < 2) return orient::number(seconds, 0) + " s";
  if (minutes < 60) return std::to_string(minutes) + " min";
  return std::to_string(minutes / 60) + " h " + (minutes % 60 < 10 ? "0" : "") + std::to_string(minutes % 60) + " min";
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
  if (const auto i = winner_of(choice, orient::kThesisWeights)) add("thesis", *i);
  if (const auto i = winner_of(choice, orient::kAhsanWeights)) add("ahsan", *i);
  return found;
}

void time_candidates(const mesh::TriangleMesh& mesh, const PrepareOptions& options, Choice& choice,
                     const run::Context& ctx) {
  const double began = options.now_s ? options.now_s() : 0;
  const auto spent = [&] { return options.now_s ? options.now_s() - began : options.budget_s; };
  if (!choice.candidates[choice.chosen].printable) return;  // nothing stands: nothing to compare
  choice.baselines = find_baselines(choice);

  std::vector<std::size_t> wave;
  for (const auto& [name, i] : choice.baselines)
    if (std::find(wave.begin(), wave.end(), i) == wave.end()) wave.push_back(i);
  ctx.progress("time", 0);
  time_all(mesh, options, choice, wave, ctx);

  const std::vector<std::size_t> queue = leaders(choice);
  for (std::size_t next = 0; next < queue.size() && spent() < options.budget_s;) {
    ctx.progress("time", std::min(1.0, spent() / options.budget_s));
    wave.clear();
    while (next < queue.size() && wave.size() < ctx.thread_count()) wave.push_back(queue[next++]);
    time_all(mesh, options, choice, wave, ctx);
  }

  const auto time_of = [&](std::size_t i) { return choice.candidates[i].predicted_s.value_or(1e300); };
  std::size_t best = choice.chosen;
  for (std::size_t i = 0; i < choice.candidates.size(); ++i) {
    const bool quicker = time_of(i) < time_of(best) ||
                         (time_of(i) == time_of(best) && choice.candidates[i].score < choice.candidates[best].score);
    if (choice.candidates[i].printable && quicker) best = i;
  }
  // Of equals, the part as it came.
  if (time_of(choice.as_delivered) <= time_of(best)) best = choice.as_delivered;
  choice.chosen = best;
  choice.ties.clear();
  for (std::size_t i = 0; i < choice.candidates.size(); ++i)
    if (choice.candidates[i].printable && time_of(i) == time_of(best)) choice.ties.push_back(i);
  choice.why = explain(choice, orient::explain(choice));
}

}  // namespace voidpath::pipeline
