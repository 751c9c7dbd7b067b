#include "config/fields.h"
#include "daemon/cli/corpus.h"
#include "daemon/cli/flags.h"
#include "daemon/cli/offline.h"
#include "engine/pipeline/find_weights.h"
#include "engine/pipeline/slice_part.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>

#include <nlohmann/json.hpp>

namespace voidpath::cli {

namespace {

struct Row {
  std::string name;
  pipeline::ModelWeights weights;
  std::string failure;  ///< empty unless the model could not be used
};

Row weigh(const CorpusModel& model, pipeline::PrepareOptions options, const run::Context& ctx) {
  Row row;
  row.name = model.name;
  options.import.scale *= model.scale;
  try {
    const auto import = mesh::import_model(model.file, options.import, ctx);
    const orient::Choice choice = orient::search(import.mesh, options.orient, ctx);
    run::Context inner = ctx;
    inner.threads = 1;
    inner.on_progress = nullptr;
    const auto time_of = [&](std::size_t i) -> std::optional<double> {
      try {
        return pipeline::time_part(import.mesh, choice.candidates[i].direction, options, inner);
      } catch (const pipeline::Refused&) {
        return std::nullopt;
      }
    };
    row.weights = pipeline::weigh_model(choice, options.orient.tie_tolerance, time_of, ctx);
    if (row.weights.timed == 0) row.failure = "no direction that the tuples pick can be printed";
  } catch (const run::Stopped&) {
    throw;
  } catch (const std::exception& e) {
    row.failure = e.what();
  }
  return row;
}

std::string weights_text(const orient::Weights& w, int decimals) {
  return "{h: " + fixed(w.h, decimals) + ", v: " + fixed(w.v, decimals) + ", d: " + fixed(w.d, decimals) +
         ", c: " + fixed(w.c, decimals) + "}";
}

std::string row_text(const Row& row) {
  if (!row.failure.empty()) return row.name + ": left out: " + row.failure;
  const auto& w = row.weights;
  std::string out = row.name + ": " + std::to_string(w.directions) + " directions";
  if (w.timed < w.directions) out += " (" + std::to_string(w.timed) + " printable)";
  out += ", " + duration_text(w.best_s) + " to " + duration_text(w.worst_s) + ", ";
  if (!w.median) return out + "the same time with all weights: no vote";
  return out + std::to_string(w.optimal_tuples) + " tuples lead to the quickest, median " +
         weights_text(*w.median, 3);
}

std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

std::string yaml(const Settings& s, const std::vector<Row>& rows, const orient::Weights& weights) {
  std::size_t votes = 0, timed = 0;
  for (const Row& r : rows) {
    votes += r.weights.median ? 1U : 0U;
    timed += r.weights.timed;
  }
  const auto& p = s.profile;
  std::string out =
      "# Weights of the four criteria for one printer, found by voidpath weights. Copy them to orient: "
      "weights: of\n"
      "# voidpath.yaml. To be found again when printer, material, quality or firmware changes.\n"
      "# Profile " +
      one_line(p.printer + ", " + p.material + ", " + p.quality) + "; sha256 " + p.sha256 +
      "\n"
      "# Directions as " +
      orient::to_string(s.options.orient.method) + " lists them, " +
      std::to_string(s.options.orient.subdivisions) + " subdivisions; " +
      std::to_string(pipeline::kAllTuples) + " tuples, of which " +
      std::to_string(pipeline::weight_tuples().size()) + " rank differently; " + std::to_string(timed) +
      " directions sliced and timed\n"
      "# Median over " +
      std::to_string(votes) + " of " + std::to_string(rows.size()) + " models:\n";
  for (const Row& r : rows) out += "#   " + one_line(row_text(r)) + "\n";
  // Four decimals, made to add up to 1.
  const auto rounded = [](double x) { return std::round(x * 1e4) / 1e4; };
  const double h = rounded(weights.h), v = rounded(weights.v), d = rounded(weights.d);
  return out + "orient:\n  weights: " + weights_text({h, v, d, std::max(0.0, 1 - h - v - d)}, 4) + "\n";
}

nlohmann::ordered_json weights_json(const orient::Weights& w) {
  return {{"h", w.h}, {"v", w.v}, {"d", w.d}, {"c", w.c}};
}

nlohmann::ordered_json json_of(const std::vector<Row>& rows, const orient::Weights& weights,
                               const std::string& file, const config::Profile& profile, double elapsed_s) {
  nlohmann::ordered_json models = nlohmann::ordered_json::array();
  for (const Row& r : rows) {
    nlohmann::ordered_json m = {{"model", r.name}};
    if (!r.failure.empty()) {
      m["failure"] = r.failure;
    } else {
      m["directions"] = r.weights.directions;
      m["timed"] = r.weights.timed;
      m["best_s"] = r.weights.best_s;
      m["worst_s"] = r.weights.worst_s;
      m["optimal_tuples"] = r.weights.optimal_tuples;
      if (r.weights.median) m["median"] = weights_json(*r.weights.median);
    }
    models.push_back(std::move(m));
  }
  return {{"file", file},
          {"weights", weights_json(weights)},
          {"tuples", pipeline::kAllTuples},
          {"distinct_tuples", pipeline::weight_tuples().size()},
          {"profile_sha256", profile.sha256},
          {"models", models},
          {"elapsed_s", elapsed_s}};
}

}  // namespace

int weights_command(const std::vector<std::string>& args) {
  CLI::App app("Finds the weights of the four criteria for a printer profile", "weights");
  CommonFlags common;
  OrientFlags orient;
  std::string corpus, out;
  app.add_option("corpus", corpus, "a folder of models, or a CSV file with a column 'file'")->required();
  app.add_option("--out", out, "the YAML file to write")->required();
  app.add_option("--jobs", common.threads, "directions timed at once; the result does not depend on it");
  add_common(app, common);
  app.add_option("--method", orient.method,
                 "whose directions: thesis (as published) or toolpath (only printable)")
      ->check(CLI::IsMember({"thesis", "toolpath"}))
      ->default_str("thesis");
  app.add_option("--subdivisions", orient.subdivisions, "samples 20*4^n directions and the six axes");
  app.add_option("--critical", orient.critical, "normals or morse: which heights bound the slabs");
  if (!parse(app, args)) return 0;
  if (orient.method.empty()) orient.method = "thesis";

  const Settings s = settings_from(common, orient);
  const std::vector<CorpusModel> models = list_corpus(corpus);
  const auto begin = std::chrono::steady_clock::now();
  std::vector<Row> rows;
  std::vector<pipeline::ModelWeights> votes;
  for (const CorpusModel& model : models) {
    rows.push_back(weigh(model, s.options, console_context(common.threads)));
    votes.push_back(rows.back().weights);
    end_progress();
    std::fprintf(stderr, "[%zu/%zu] %s\n", rows.size(), models.size(), row_text(rows.back()).c_str());
  }
  const auto weights = pipeline::median_weights(votes);
  if (!weights)
    throw std::runtime_error(corpus +
                             ": none of the models tells anything about the weights; nothing was written");
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();

  std::ofstream file(out, std::ios::trunc);
  file << yaml(s, rows, *weights);
  file.close();
  if (!file) throw std::runtime_error(out + ": cannot be written");
  if (common.json)
    std::cout << json_of(rows, *weights, out, s.profile, elapsed).dump(2) << '\n';
  else
    std::printf("%s: %s from %zu models in %s\n", out.c_str(), weights_text(*weights, 4).c_str(), rows.size(),
                duration_text(elapsed).c_str());
  return 0;
}

}  // namespace voidpath::cli
