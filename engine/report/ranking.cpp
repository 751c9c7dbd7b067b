#include "engine/report/ranking.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace voidpath::report {

namespace {

constexpr double kOtherKind_cos = 0.9;
constexpr std::size_t kRunnersUp = 3;

std::pair<double, double> rank(const orient::Candidate& c) {
  return {c.predicted_s.value_or(std::numeric_limits<double>::infinity()), c.score};
}

/// The others say where a direction points: as delivered says that already.
bool is_method(const std::string& baseline) { return baseline == "thesis" || baseline == "ahsan"; }

/// What the search calls its baselines, for people.
std::string spoken(const std::string& baseline) {
  if (baseline == "thesis") return "best by four criteria";
  if (baseline == "ahsan") return "best by three criteria";
  if (baseline.rfind("axis -", 0) == 0) return "axis −" + baseline.substr(6);
  return baseline;
}

}  // namespace

std::vector<std::size_t> runners_up(const orient::Choice& choice, std::size_t count) {
  std::vector<std::size_t> order(choice.candidates.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return rank(choice.candidates[a]) < rank(choice.candidates[b]);
  });
  std::vector<std::size_t> named = {choice.chosen, choice.as_delivered};
  std::vector<std::size_t> out;
  for (const std::size_t i : order) {
    if (out.size() == count) break;
    const auto& c = choice.candidates[i];
    if (choice.method == orient::Method::toolpath && !c.printable) continue;
    const bool other = std::all_of(named.begin(), named.end(), [&](std::size_t n) {
      return choice.candidates[n].direction.dot(c.direction) < kOtherKind_cos;
    });
    if (!other) continue;
    named.push_back(i);
    out.push_back(i);
  }
  return out;
}

std::vector<Named> ranking(const orient::Choice& choice) {
  std::vector<Named> out;
  const auto add = [&](std::size_t i, const std::string& name) {
    const auto it = std::find_if(out.begin(), out.end(), [i](const Named& n) { return n.candidate == i; });
    if (it == out.end())
      out.push_back({i, name, ""});
    else
      it->name += " · " + name;
  };
  add(choice.chosen, "chosen");
  add(choice.as_delivered, "as delivered");
  const auto first_other = static_cast<std::ptrdiff_t>(out.size());
  for (const auto& [name, i] : choice.baselines)
    if (i != choice.as_delivered || is_method(name)) add(i, spoken(name));
  for (const std::size_t i : runners_up(choice, kRunnersUp)) {
    const bool known = std::any_of(out.begin(), out.end(), [i](const Named& n) { return n.candidate == i; });
    if (!known) add(i, "runner-up");
  }
  std::stable_sort(out.begin() + first_other, out.end(), [&](const Named& a, const Named& b) {
    return rank(choice.candidates[a.candidate]) < rank(choice.candidates[b.candidate]);
  });
  int number = 0;
  for (Named& n : out)
    n.mark = n.candidate == choice.chosen         ? "★"
             : n.candidate == choice.as_delivered ? "D"
                                                  : std::to_string(++number);
  return out;
}

}  // namespace voidpath::report
