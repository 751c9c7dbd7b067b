#include "engine/evaluate/summary.h"

#include "engine/orient/words.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace voidpath::evaluate {

using orient::number;

Pair compare_methods(const std::vector<Row>& rows, const std::string& a, const std::string& b) {
  Pair out;
  for (const std::string& model : models_of(rows)) {
    const Row* ra = find_row(rows, model, a);
    const Row* rb = find_row(rows, model, b);
    if (ra == nullptr || rb == nullptr || !ra->predicted_s || !rb->predicted_s) continue;
    out.ratios.push_back(*ra->predicted_s / *rb->predicted_s);
    out.models.push_back(model);
  }
  return out;
}

Shares shares_of(const std::vector<double>& ratios) {
  Shares s;
  s.count = ratios.size();
  if (ratios.empty()) return s;
  const double one = 1 / static_cast<double>(ratios.size());
  for (const double r : ratios) (r > 1 + kSame ? s.above : r < 1 - kSame ? s.below : s.equal) += one;
  return s;
}

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  const double at = q * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  return values[low] + (at - static_cast<double>(low)) * (values[high] - values[low]);
}

std::vector<std::string> models_of(const std::vector<Row>& rows) {
  std::vector<std::string> out;
  std::set<std::string> seen;
  for (const Row& r : rows)
    if (seen.insert(r.model).second) out.push_back(r.model);
  return out;
}

const Row* find_row(const std::vector<Row>& rows, const std::string& model, const std::string& method) {
  for (const Row& r : rows)
    if (r.model == model && r.method == method) return &r;
  return nullptr;
}

std::string summary_text(const std::vector<Row>& rows) {
  const auto percent = [](double share) { return number(100 * share, 1) + " %"; };
  std::string out;
  const Pair paper = compare_methods(rows, "ahsan", "thesis");
  if (!paper.ratios.empty()) {
    const Shares s = shares_of(paper.ratios);
    out += "four criteria against three, " + std::to_string(s.count) + " models: " + percent(s.equal) +
           " equal, " + percent(s.above) + " faster, " + percent(s.below) +
           " slower (published: 62, 15, 23 %)\n";
  }
  for (const std::string& method : known_methods()) {
    if (method == "toolpath" || method == "oracle") continue;
    const Pair pair = compare_methods(rows, method, "toolpath");
    if (pair.ratios.empty()) continue;
    const Shares s = shares_of(pair.ratios);
    out += "toolpath against " + method + ", " + std::to_string(s.count) + " models: takes " +
           percent(1 - 1 / quantile(pair.ratios, 0.5)) + " less at the median, " +
           percent(1 - 1 / quantile(pair.ratios, 1)) + " at best; faster in " + percent(s.above) +
           ", slower in " + percent(s.below) + "\n";
  }
  std::size_t counted = 0, incomplete = 0, in_full = 0, asked = 0, turned = 0;
  double longest_s = 0;
  for (const Row& r : rows) {
    if (r.method != "toolpath" || !r.predicted_s) continue;
    ++counted;
    incomplete += r.complete ? 0U : 1U;
    in_full += r.in_full;
    asked += r.asked;
    turned += r.turn_rad != 0 ? 1U : 0U;
    longest_s = std::max(longest_s, r.elapsed_s);
  }
  if (asked > 0)
    out += "toolpath timed " + std::to_string(in_full) + " of " + std::to_string(asked) +
           " directions in full, the others on a sample of layers; not all settled in " +
           std::to_string(incomplete) + " of " + std::to_string(counted) +
           " models; turned about the build axis in " + std::to_string(turned) + "; at most " +
           number(longest_s, 1) + " s a model\n";
  const Pair regret = compare_methods(rows, "toolpath", "oracle");
  if (!regret.ratios.empty())
    out += "regret of toolpath against every direction timed, " + std::to_string(regret.ratios.size()) +
           " models: " + percent(quantile(regret.ratios, 0.5) - 1) + " at the median, " +
           percent(quantile(regret.ratios, 0.95) - 1) + " at the 95th percentile, " +
           percent(quantile(regret.ratios, 1) - 1) + " at worst\n";
  return out;
}

}  // namespace voidpath::evaluate
