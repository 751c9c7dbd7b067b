#include "engine/pipeline/find_weights.h"

#include "engine/orient/score.h"
#include "engine/run/parallel_for.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace voidpath::pipeline {

namespace {

using orient::Weights;

constexpr int kTenths = 10;
constexpr std::array<double Weights::*, 4> kEach = {&Weights::h, &Weights::v, &Weights::d, &Weights::c};

double sum_of(const Weights& w) { return w.h + w.v + w.d + w.c; }

Weights scaled(const Weights& w, double factor) {
  return {w.h * factor, w.v * factor, w.d * factor, w.c * factor};
}

/// Mean of the two middle ones where there is no middle one.
double median(std::vector<double> values) {
  const std::size_t half = values.size() / 2;
  std::sort(values.begin(), values.end());
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

Weights median(const std::vector<Weights>& all) {
  Weights out;
  std::vector<double> values(all.size());
  for (const auto weight : kEach) {
    std::transform(all.begin(), all.end(), values.begin(), [&](const Weights& w) { return w.*weight; });
    out.*weight = median(values);
  }
  return out;
}

Weights mean(const std::vector<Weights>& all) {
  Weights out{0, 0, 0, 0};
  for (const auto weight : kEach) {
    for (const Weights& w : all) out.*weight += w.*weight / static_cast<double>(all.size());
  }
  return out;
}

/// The median of each weight, summing to 1; where no weight counts in half of them, the mean.
Weights middle(const std::vector<Weights>& all) {
  Weights w = median(all);
  if (sum_of(w) <= 0) w = mean(all);
  return scaled(w, 1 / sum_of(w));
}

/// The candidates that may win with their four criteria scaled as the score does, best rank first: of equal
/// scores the printable one wins, then the part as it came, then the first.
struct Field {
  std::vector<std::size_t> index;
  std::vector<std::array<double, 4>> scaled;  ///< h, v, d, c
};

Field make_field(const orient::Choice& choice) {
  std::array<std::vector<orient::Candidate>, 4> columns;
  columns.fill(choice.candidates);
  for (std::size_t k = 0; k < 4; ++k) {
    Weights one{0, 0, 0, 0};
    one.*kEach[k] = 1;
    orient::score(columns[k], one);
  }
  Field field;
  const auto& all = choice.candidates;
  const bool only_printable = choice.method == orient::Method::toolpath &&
                              std::any_of(all.begin(), all.end(), [](const auto& c) { return c.printable; });
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].printable || !only_printable) field.index.push_back(i);
  std::stable_sort(field.index.begin(), field.index.end(), [&](std::size_t a, std::size_t b) {
    const auto rank = [&](std::size_t i) {
      return std::pair(!choice.candidates[i].printable, i != choice.as_delivered);
    };
    return rank(a) < rank(b);
  });
  for (const std::size_t i : field.index)
    field.scaled.push_back(
        {columns[0][i].score, columns[1][i].score, columns[2][i].score, columns[3][i].score});
  return field;
}

std::size_t pick(const Field& field, const Weights& w, double tie_tolerance, std::vector<double>& scores) {
  scores.clear();
  for (const auto& x : field.scaled) scores.push_back(w.h * x[0] + w.v * x[1] + w.d * x[2] + w.c * x[3]);
  const double limit = *std::min_element(scores.begin(), scores.end()) + tie_tolerance;
  const auto first = std::find_if(scores.begin(), scores.end(), [&](double s) { return s <= limit; });
  return field.index[static_cast<std::size_t>(first - scores.begin())];
}

std::vector<Weights> make_tuples() {
  std::vector<Weights> out;
  for (int h = 0; h <= kTenths; ++h)
    for (int v = 0; v <= kTenths; ++v)
      for (int d = 0; d <= kTenths; ++d)
        for (int c = 0; c <= kTenths; ++c) {
          if (std::gcd(std::gcd(h, v), std::gcd(d, c)) != 1) continue;
          const double sum = h + v + d + c;
          out.push_back({h / sum, v / sum, d / sum, c / sum});
        }
  return out;
}

}  // namespace

const std::vector<Weights>& weight_tuples() {
  static const std::vector<Weights> tuples = make_tuples();
  return tuples;
}

std::vector<std::size_t> picks_of_tuples(const orient::Choice& choice, double tie_tolerance) {
  const Field field = make_field(choice);
  std::vector<std::size_t> picks;
  std::vector<double> scores;
  picks.reserve(weight_tuples().size());
  for (const Weights& w : weight_tuples()) picks.push_back(pick(field, w, tie_tolerance, scores));
  return picks;
}

ModelWeights weigh_model(const orient::Choice& choice, double tie_tolerance, const TimeOf& time_of,
                         const run::Context& ctx) {
  const std::vector<std::size_t> picks = picks_of_tuples(choice, tie_tolerance);
  std::vector<std::size_t> directions = picks;
  std::sort(directions.begin(), directions.end());
  directions.erase(std::unique(directions.begin(), directions.end()), directions.end());

  std::vector<std::optional<double>> times(directions.size());
  run::parallel_for(ctx, directions.size(), [&](std::size_t i) { times[i] = time_of(directions[i]); });

  ModelWeights out;
  out.directions = directions.size();
  for (const auto& t : times) {
    if (!t) continue;
    out.best_s = out.timed == 0 ? *t : std::min(out.best_s, *t);
    out.worst_s = std::max(out.worst_s, *t);
    ++out.timed;
  }
  const double limit = out.best_s * (1 + kSameTime);
  std::vector<Weights> optimal;
  for (std::size_t i = 0; i < picks.size(); ++i) {
    const auto at = std::lower_bound(directions.begin(), directions.end(), picks[i]) - directions.begin();
    const auto& t = times[static_cast<std::size_t>(at)];
    if (t && *t <= limit) optimal.push_back(weight_tuples()[i]);
  }
  out.optimal_tuples = optimal.size();
  if (!optimal.empty() && optimal.size() < picks.size()) out.median = middle(optimal);
  return out;
}

std::optional<Weights> median_weights(const std::vector<ModelWeights>& models) {
  std::vector<Weights> votes;
  for (const ModelWeights& m : models)
    if (m.median) votes.push_back(*m.median);
  if (votes.empty()) return std::nullopt;
  return middle(votes);
}

}  // namespace voidpath::pipeline
