#include "engine/pipeline/trial.h"

#include "engine/pipeline/sample_time.h"
#include "engine/run/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace voidpath::pipeline {

namespace {

using orient::Candidate;

/// Candidates timed in full between two looks at what that tells of the others.
constexpr std::size_t kSettleWave = 2;
/// What samples are trusted to before any was compared with a full time, as a share: over varied models nine
/// of ten samples are nearer than that.
constexpr double kUntriedError = 0.10;
/// As many comparisons are enough to trust them instead.
constexpr std::size_t kTried = 3;
/// Never trusted to more than this: directions may differ in what samples miss.
constexpr double kLeastError = 0.04;
/// Before the first full timing: what it takes of a sample's cost times the layers that it plans for each of
/// the sample's. Less than 1, since samples cut the whole part as well.
constexpr double kLayersCost = 0.65;
/// What a sample of few layers takes of what the usual one does: the whole part is cut for either.
constexpr double kFewCost = 0.5;
/// The largest deviation seen so far is not the largest there is.
constexpr double kErrorMargin = 1.5;

double median(std::vector<double> v) {
  const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  if (v.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(v.begin(), middle));
}

}  // namespace

Trial::Trial(const mesh::TriangleMesh& mesh, const PrepareOptions& options, orient::Choice& choice,
             const run::Context& ctx)
    : mesh_(mesh), options_(options), choice_(choice), ctx_(ctx), budget_(options) {}

bool Trial::run(const std::vector<std::size_t>& which,
                const std::function<void(std::size_t, const run::Context&)>& body) {
  costs_.resize(choice_.candidates.size());
  run::Context inner = ctx_;
  inner.on_progress = nullptr;
  // One candidate a thread; threads that are left over help.
  inner.threads =
      std::max(1U, ctx_.thread_count() / static_cast<unsigned>(std::max<std::size_t>(which.size(), 1)));
  std::atomic<bool> in_time{true};
  run::parallel_for(ctx_, which.size(), [&](std::size_t k) {
    Candidate& c = choice_.candidates[which[k]];
    try {
      if (!ended_in_time(budget_, inner, [&](const run::Context& ctx) { body(which[k], ctx); }))
        in_time = false;
    } catch (const Refused& e) {
      c.printable = false;
      c.why = e.what();
    }
  });
  ctx_.progress("time", budget_.fraction());
  return in_time;
}

void Trial::sample(const std::vector<std::size_t>& which, bool few) {
  std::atomic<bool> spent{false};
  const bool in_time = run(which, [&](std::size_t i, const run::Context& inner) {
    Candidate& c = choice_.candidates[i];
    if (c.predicted_s || c.sampled_s) return;
    if (!budget_.has_room(expected_sample_s(few))) {
      spent = true;
      return;
    }
    const double began = budget_.spent();
    const SampledTime t = sample_time(mesh_, c, options_, inner, few ? kFewSamples : kSamples);
    (t.planned == t.layers ? c.predicted_s : c.sampled_s) = t.seconds;
    const double took = budget_.spent() - began;
    const std::lock_guard lock(mutex_);
    costs_[i] = {took, t.layers > 0 ? static_cast<double>(t.planned) / static_cast<double>(t.layers) : 1};
    Spent& sum = few ? few_samples_ : samples_;
    sum.seconds += took;
    ++sum.count;
  });
  budget_spent_ = budget_spent_ || spent || !in_time;
}

void Trial::time_full(const std::vector<std::size_t>& which) {
  const bool in_time = run(which, [&](std::size_t i, const run::Context& inner) {
    Candidate& c = choice_.candidates[i];
    const double began = budget_.spent();
    c.predicted_s = time_part(mesh_, c, options_, inner);
    const double took = budget_.spent() - began;
    const std::lock_guard lock(mutex_);
    if (costs_[i].sample_s > 0) {
      full_over_sample_ += took / costs_[i].sample_s;
      ++fulls_;
    }
  });
  budget_spent_ = budget_spent_ || !in_time;
}

double Trial::expected_sample_s(bool few) const {
  const std::lock_guard lock(mutex_);
  if (few && few_samples_.count > 0) return few_samples_.seconds / few_samples_.count;
  const double each = samples_.count > 0 ? samples_.seconds / samples_.count : 0;
  return few ? each * kFewCost : each;
}

double Trial::expected_sampling_s(std::size_t count) const {
  const auto threads =
      static_cast<double>(std::min<std::size_t>(ctx_.thread_count(), std::max<std::size_t>(count, 1)));
  return expected_sample_s(false) * static_cast<double>(count) / threads;
}

double Trial::expected_full_s(std::size_t i) const {
  if (i >= costs_.size()) return 0;
  const double ratio = fulls_ > 0 ? full_over_sample_ / fulls_ : kLayersCost / costs_[i].share;
  return costs_[i].sample_s * ratio;
}

std::vector<double> Trial::deviations() const {
  std::vector<double> out;
  for (const Candidate& c : choice_.candidates)
    if (c.predicted_s && c.sampled_s && *c.predicted_s > 0 && *c.sampled_s > 0)
      out.push_back(std::log(*c.predicted_s / *c.sampled_s));
  return out;
}

double Trial::bias() const {
  const std::vector<double> d = deviations();
  return d.empty() ? 1 : std::exp(median(d));
}

double Trial::sample_error() const {
  const std::vector<double> d = deviations();
  const double middle = d.empty() ? 0 : median(d);
  double most = 0;
  for (const double x : d) most = std::max(most, std::abs(x - middle));
  return std::max(d.size() < kTried ? kUntriedError : kLeastError, kErrorMargin * most);
}

std::optional<double> Trial::known(std::size_t i) const {
  const Candidate& c = choice_.candidates[i];
  if (c.predicted_s) return c.predicted_s;
  if (c.sampled_s) return *c.sampled_s * bias();
  return std::nullopt;
}

std::optional<std::size_t> Trial::best() const {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < choice_.candidates.size(); ++i) {
    const Candidate& c = choice_.candidates[i];
    if (!c.printable || !c.predicted_s) continue;
    if (!best || *c.predicted_s < *choice_.candidates[*best].predicted_s) best = i;
  }
  return best;
}

bool Trial::settle_while(const std::vector<std::size_t>& among,
                         const std::function<bool(std::size_t)>& wanted) {
  for (;;) {
    std::vector<std::size_t> open;
    for (const std::size_t i : among) {
      const Candidate& c = choice_.candidates[i];
      if (c.printable && c.sampled_s && !c.predicted_s && wanted(i)) open.push_back(i);
    }
    if (open.empty()) return true;
    std::stable_sort(open.begin(), open.end(), [&](std::size_t a, std::size_t b) {
      return *choice_.candidates[a].sampled_s < *choice_.candidates[b].sampled_s;
    });
    std::vector<std::size_t> wave;
    for (const std::size_t i : open)
      if (wave.size() < kSettleWave && budget_.has_room(expected_full_s(i))) wave.push_back(i);
    if (wave.empty() || wave.front() != open.front()) {
      budget_spent_ = true;
      if (wave.empty()) return false;
    }
    time_full(wave);
  }
}

bool Trial::settle(const std::vector<std::size_t>& among) {
  return settle_while(among, [this](std::size_t i) {
    const auto leader = best();
    return !leader || *known(i) * (1 - sample_error()) < *choice_.candidates[*leader].predicted_s;
  });
}

bool Trial::time_rest(const std::vector<std::size_t>& among) {
  return settle_while(among, [](std::size_t) { return true; });
}

}  // namespace voidpath::pipeline
