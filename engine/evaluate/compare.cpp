#include "engine/evaluate/compare.h"

#include "engine/pipeline/baselines.h"
#include "engine/pipeline/slice_part.h"
#include "engine/pipeline/time_candidates.h"
#include "engine/run/parallel_for.h"

#include <algorithm>
#include <map>
#include <set>

namespace voidpath::evaluate {

namespace {

using pipeline::Only;

/// One model under comparison: the search's candidates, and what has been timed of them so far.
class Bench {
 public:
  Bench(const mesh::TriangleMesh& mesh, const CompareOptions& options, const run::Context& ctx)
      : mesh_(mesh), options_(options), ctx_(ctx) {
    orient::SearchOptions search = options.prepare.orient;
    search.method = orient::Method::toolpath;
    const double began = now();
    choice_ = orient::search(mesh, search, ctx);
    search_s_ = now() - began;
  }

  Row run(const std::string& method) {
    asked_.clear();
    Row row;
    row.method = method;
    if (method == "toolpath")
      choose_by_toolpath(row);
    else
      choose(method, row);
    return row;
  }

 private:
  double now() const { return options_.now_s ? options_.now_s() : 0; }
  double tie_tolerance() const { return options_.prepare.orient.tie_tolerance; }

  /// Times the candidates that have not been yet. Those that turn out not to be printable are marked so.
  void time(const std::vector<std::size_t>& which) {
    run::Context inner = ctx_;
    inner.threads = 1;
    inner.on_progress = nullptr;
    std::vector<double> costs(which.size());
    run::parallel_for(ctx_, which.size(), [&](std::size_t k) {
      orient::Candidate& c = choice_.candidates[which[k]];
      if (c.predicted_s || !c.printable) return;
      const double began = now();
      try {
        c.predicted_s = pipeline::time_part(mesh_, c, options_.prepare, inner);
      } catch (const pipeline::Refused& e) {
        c.printable = false;
        c.why = e.what();
      }
      costs[k] = now() - began;
    });
    for (std::size_t k = 0; k < which.size(); ++k) {
      cost_s_.emplace(which[k], costs[k]);
      asked_.insert(which[k]);
    }
  }

  std::optional<std::size_t> pick(const std::string& method) {
    if (method == "thesis")
      return pipeline::score_winner(choice_, orient::kThesisWeights, Only::printable, tie_tolerance());
    if (method == "ahsan")
      return pipeline::score_winner(choice_, orient::kAhsanWeights, Only::printable, tie_tolerance());
    if (method == "thesis-published")
      return pipeline::score_winner(choice_, orient::kThesisWeights, Only::any, tie_tolerance());
    if (method == "ahsan-published")
      return pipeline::score_winner(choice_, orient::kAhsanWeights, Only::any, tie_tolerance());
    if (method == "as-delivered") return choice_.as_delivered;
    if (method == "lowest") return pipeline::lowest(choice_);
    if (method == "axes") return quickest_of(list(true));
    if (method == "oracle") return quickest_of(list(false));
    if (under_.empty()) under_ = pipeline::undersides_of(mesh_, choice_, options_.prepare, ctx_);
    return pipeline::least_overhang(choice_, under_, mesh::surface_area(mesh_));
  }

  std::vector<std::size_t> list(bool only_axes) const {
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < choice_.candidates.size(); ++i)
      if (!only_axes || choice_.candidates[i].origin == orient::Origin::axis) out.push_back(i);
    return out;
  }

  std::optional<std::size_t> quickest_of(const std::vector<std::size_t>& which) {
    time(which);
    std::optional<std::size_t> best;
    for (const std::size_t i : which) {
      const auto& t = choice_.candidates[i].predicted_s;
      if (t && (!best || *t < *choice_.candidates[*best].predicted_s)) best = i;
    }
    return best;
  }

  void choose(const std::string& method, Row& row) {
    std::optional<std::size_t> i = pick(method);
    while (i && choice_.candidates[*i].printable && !choice_.candidates[*i].predicted_s) {
      time({*i});
      i = pick(method);  // another, where the first cannot be sliced
    }
    if (i)
      fill(row, choice_.candidates[*i]);
    else
      row.why = "none of its directions can be printed";
    row.elapsed_s = search_s_ + cost_of_asked();
  }

  /// As for a user: knowing nothing of what other methods had timed, and by the budget less the search.
  void choose_by_toolpath(Row& row) {
    orient::Choice choice = choice_;
    for (orient::Candidate& c : choice.candidates) c.predicted_s.reset();
    pipeline::PrepareOptions prepare = options_.prepare;
    if (prepare.now_s) prepare.budget_s -= search_s_;
    const double began = now();
    pipeline::time_candidates(mesh_, prepare, choice, ctx_);
    row.elapsed_s = search_s_ + now() - began;
    orient::Candidate& chosen = choice.candidates[choice.chosen];
    if (!chosen.predicted_s && chosen.printable)
      chosen.predicted_s = pipeline::time_part(mesh_, chosen, prepare, ctx_);
    fill(row, chosen);
    const orient::Timing& t = choice.timing;
    row.asked = t.asked;
    row.in_full = t.in_full;
    row.sampled = t.sampled;
    row.complete = t.complete;
    // What it found out need not be found out again by the oracle.
    for (std::size_t i = 0; i < choice_.candidates.size(); ++i)
      if (!choice_.candidates[i].predicted_s)
        choice_.candidates[i].predicted_s = choice.candidates[i].predicted_s;
  }

  double cost_of_asked() const {
    double sum = 0;
    for (const std::size_t i : asked_) {
      const auto cost = cost_s_.find(i);
      if (cost != cost_s_.end()) sum += cost->second;
    }
    return sum;
  }

  static void fill(Row& row, const orient::Candidate& c) {
    row.direction = c.direction;
    row.criteria = c.criteria;
    row.predicted_s = c.predicted_s;
    row.turn_rad = c.turn_rad;
    if (!c.printable) row.why = c.why;
  }

  const mesh::TriangleMesh& mesh_;
  const CompareOptions& options_;
  const run::Context& ctx_;
  orient::Choice choice_;
  double search_s_ = 0;
  std::vector<pipeline::Underside> under_;
  std::map<std::size_t, double> cost_s_;  ///< of slicing and timing, per candidate
  std::set<std::size_t> asked_;           ///< candidates the present method needs the time of
};

}  // namespace

const std::vector<std::string>& default_methods() {
  static const std::vector<std::string> names = {"thesis",         "ahsan", "toolpath", "as-delivered",
                                                 "lowest",         "axes",  "tweaker",  "thesis-published",
                                                 "ahsan-published"};
  return names;
}

const std::vector<std::string>& known_methods() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all = default_methods();
    all.push_back("oracle");
    return all;
  }();
  return names;
}

std::vector<Row> compare(const std::string& model, const mesh::TriangleMesh& mesh,
                         const CompareOptions& options, const run::Context& ctx) {
  Bench bench(mesh, options, ctx);
  const Row delivered = bench.run("as-delivered");
  std::map<std::string, Row> rows;
  // The oracle last: it uses whatever has been timed.
  const auto is_late = [](const std::string& method) { return method == "toolpath" || method == "oracle"; };
  for (const std::string& method : options.methods)
    if (!is_late(method)) rows[method] = bench.run(method);
  for (const char* method : {"toolpath", "oracle"})
    if (std::count(options.methods.begin(), options.methods.end(), method) > 0)
      rows[method] = bench.run(method);
  std::vector<Row> out;
  for (const std::string& method : options.methods) {
    Row row = rows.at(method);
    row.model = model;
    row.triangles = mesh.triangles.size();
    if (row.predicted_s && delivered.predicted_s) row.ratio = *row.predicted_s / *delivered.predicted_s;
    out.push_back(std::move(row));
  }
  return out;
}

Row failed(const std::string& model, const std::string& why) {
  Row row;
  row.model = model;
  row.why = why;
  return row;
}

}  // namespace voidpath::evaluate
