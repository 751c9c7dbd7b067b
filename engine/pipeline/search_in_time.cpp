#include "engine/pipeline/search_in_time.h"

#include "engine/orient/directions.h"
#include "engine/orient/evaluate.h"
#include "engine/orient/score.h"

#include <algorithm>
#include <mutex>
#include <numeric>
#include <optional>

namespace voidpath::pipeline {

namespace {

/// Of the budget, what a search may take: the rest goes to slicing, which is what decides.
constexpr double kSearchShare = 0.45;
/// Resting faces that are looked at before any sampled direction, the largest ones.
constexpr std::size_t kFirstFaces = 20;
/// Sampled directions between two looks at the clock, as pairs: both ways along a line cost as one.
constexpr std::size_t kPairs = 24;
/// A resting face this near to an axis is that axis. rad
constexpr double kSameDirection = 1e-6;
/// Pace is believed after this share of the directions; they are about equally dear.
constexpr double kPaceShare = 0.05;

/// Watches one search and says when it is to be broken off. Any thread.
class Pace {
 public:
  Pace(const Budget& budget, double until_s) : budget_(budget), until_s_(until_s) {}

  void at(double fraction) {
    const double now = budget_.spent();
    const std::lock_guard lock(mutex_);
    if (!first_) first_ = {now, fraction};
    if (fraction > last_.fraction) last_ = {now, fraction};
  }
  bool hopeless() const {
    const double now = budget_.spent();
    if (now >= until_s_) return true;
    const auto whole = whole_s();
    const std::lock_guard lock(mutex_);
    return whole && first_->spent_s + *whole > until_s_;
  }
  /// What all its directions take, without what comes before them; nothing as long as that is a guess.
  std::optional<double> whole_s() const {
    const std::lock_guard lock(mutex_);
    if (!first_ || last_.fraction - first_->fraction < kPaceShare) return std::nullopt;
    return (last_.spent_s - first_->spent_s) / (last_.fraction - first_->fraction);
  }

 private:
  struct Mark {
    double spent_s = 0;
    double fraction = 0;
  };
  const Budget& budget_;
  double until_s_;
  mutable std::mutex mutex_;
  std::optional<Mark> first_;
  Mark last_;
};

/// Nothing when it was broken off.
std::optional<orient::Choice> search_until(const mesh::TriangleMesh& mesh,
                                           const orient::SearchOptions& options, Pace& pace,
                                           const run::Context& ctx) {
  run::Context inner = ctx;
  inner.on_progress = [&](std::string_view phase, double fraction) {
    pace.at(fraction);
    ctx.progress(phase, fraction);
  };
  inner.over = [&] { return (ctx.over && ctx.over()) || pace.hopeless(); };
  try {
    return orient::search(mesh, options, inner);
  } catch (const run::Stopped&) {
    ctx.check();
    return std::nullopt;
  }
}

/// Candidates of a search in the order in which they are looked at while there is time.
class Piecemeal {
 public:
  Piecemeal(const mesh::TriangleMesh& mesh, const orient::SearchOptions& options, const run::Context& ctx)
      : options_(options), ctx_(ctx), solid_(orient::prepare_solid(mesh, ctx)) {
    ctx_.on_progress = nullptr;  // told by the search that was broken off
    for (const auto& face : orient::resting_faces(mesh.vertices)) {
      const auto& d = face.direction;
      const auto axes = orient::axis_directions();
      const bool is_new = std::none_of(axes.begin(), axes.end(),
                                       [&](const auto& axis) { return (axis - d).norm() < kSameDirection; });
      if (is_new) faces_.push_back(d);
    }
  }

  /// The axes and the largest faces, whatever the clock says; then the sampled directions, from all sides at
  /// once, then the other faces, until then; to the end of the budget as long as nothing stands: without that
  /// there is nothing to slice.
  std::vector<orient::Candidate> look(const Budget& budget, double until_s) {
    const std::size_t first = std::min(faces_.size(), kFirstFaces);
    const auto middle = faces_.begin() + static_cast<std::ptrdiff_t>(first);
    look_at(orient::axis_directions(), Origin::axis, ctx_);
    look_at({faces_.begin(), middle}, Origin::resting_face, ctx_);
    run::Context inner = ctx_;
    inner.over = [&, outer = ctx_.over] {
      return (outer && outer()) || (stands_ ? budget.spent() >= until_s : !budget.has_room(0));
    };
    try {
      const auto sampled = orient::icosphere_directions(options_.subdivisions);
      const std::size_t pairs = sampled.size() / 2;
      // Near the golden section of a number of pairs that is 10·4^n: a stride that leaves none out.
      const std::size_t stride = coprime(static_cast<std::size_t>(0.618 * static_cast<double>(pairs)), pairs);
      for (std::size_t from = 0; from < pairs; from += kPairs) {
        std::vector<geom::Vec3> some;
        for (std::size_t k = from; k < std::min(pairs, from + kPairs); ++k) {
          const std::size_t pair = k * stride % pairs;
          some.insert(some.end(), {sampled[2 * pair], sampled[2 * pair + 1]});
        }
        look_at(some, Origin::sampled, inner);
      }
      look_at({middle, faces_.end()}, Origin::resting_face, inner);
    } catch (const run::Stopped&) {
      ctx_.check();
    }
    return std::move(candidates_);
  }

 private:
  using Origin = orient::Origin;

  static std::size_t coprime(std::size_t at_least, std::size_t to) {
    std::size_t n = std::max<std::size_t>(at_least, 1);
    while (std::gcd(n, to) != 1) ++n;
    return n;
  }

  void look_at(const std::vector<geom::Vec3>& directions, Origin origin, const run::Context& ctx) {
    if (directions.empty()) return;
    const auto evaluations = orient::evaluate_all(solid_, directions, options_, ctx);
    for (std::size_t i = 0; i < directions.size(); ++i) {
      orient::Candidate c;
      c.direction = directions[i];
      c.origin = origin;
      c.criteria = evaluations[i].criteria;
      c.why = evaluations[i].why_not;
      c.printable = c.why.empty();
      stands_ = stands_ || c.printable;
      candidates_.push_back(std::move(c));
    }
  }

  const orient::SearchOptions& options_;
  run::Context ctx_;
  orient::Solid solid_;
  std::vector<geom::Vec3> faces_;
  std::vector<orient::Candidate> candidates_;
  bool stands_ = false;  ///< some candidate; written between the looks, read during them
};

/// Whether it is only its stand that a candidate lacks.
bool fits_volume(const orient::Candidate& c) {
  return c.why.rfind("too tall", 0) != 0 && c.why.rfind("too large", 0) != 0;
}

/// Chosen by score among those that can be printed, else among those that fit. Nothing where none does.
std::optional<orient::Choice> choice_of(std::vector<orient::Candidate> candidates,
                                        const orient::SearchOptions& options) {
  orient::Choice out;
  out.method = options.method;
  out.weights = options.weights;
  orient::score(candidates, options.weights);
  const bool some_stand =
      std::any_of(candidates.begin(), candidates.end(), [](const auto& c) { return c.printable; });
  const auto may_win = [&](const orient::Candidate& c) { return some_stand ? c.printable : fits_volume(c); };
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const orient::Candidate& c = candidates[i];
    if (c.origin == orient::Origin::axis && c.direction == geom::Vec3::UnitZ()) out.as_delivered = i;
    if (may_win(c) && (!best || c.score < candidates[*best].score)) best = i;
  }
  if (!best) return std::nullopt;
  const auto& delivered = candidates[out.as_delivered];
  if (may_win(delivered) && delivered.score <= candidates[*best].score + options.tie_tolerance)
    best = out.as_delivered;
  out.candidates = std::move(candidates);
  out.chosen = *best;
  out.ties = {*best};
  out.why = orient::explain(out);
  if (!some_stand) out.why = "none of these stands by itself, a brim has to hold the part: " + out.why;
  return out;
}

}  // namespace

SearchInTime search_in_time(const mesh::TriangleMesh& mesh, const PrepareOptions& options,
                            const Budget& budget, const run::Context& ctx) {
  const orient::SearchOptions& search = options.orient;
  if (!budget.limited() || options.budget_s <= 0) return {orient::search(mesh, search, ctx), false};
  const double until_s = kSearchShare * options.budget_s;
  Pace pace(budget, until_s);
  if (auto choice = search_until(mesh, search, pace, ctx)) return {std::move(*choice), false};
  if (auto choice = choice_of(Piecemeal(mesh, search, ctx).look(budget, until_s), search))
    return {std::move(*choice), true};
  // Nothing fits so far: what could is for the whole search to find, or it says so.
  return {orient::search(mesh, search, ctx), false};
}

}  // namespace voidpath::pipeline
