#include "config/digest.h"
#include "daemon/cli/corpus.h"
#include "daemon/cli/flags.h"
#include "daemon/cli/offline.h"
#include "daemon/version.h"
#include "engine/evaluate/page.h"
#include "engine/evaluate/summary.h"
#include "engine/evaluate/table.h"
#include "engine/run/parallel_for.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <iterator>
#include <mutex>

#include <nlohmann/json.hpp>

namespace voidpath::cli {

namespace fs = std::filesystem;

namespace {

/// Candidates timed beyond the baselines: by number and not by the clock, so that the tables of two machines
/// are the same.
constexpr std::size_t kExtra = 16;

std::vector<std::string> methods_from(const std::string& list) {
  std::vector<std::string> out;
  std::size_t begin = 0;
  while (begin <= list.size()) {
    const std::size_t comma = std::min(list.find(',', begin), list.size());
    const std::string name = list.substr(begin, comma - begin);
    const auto& known = evaluate::known_methods();
    if (std::count(known.begin(), known.end(), name) == 0) {
      std::string all;
      for (const auto& k : known) all += (all.empty() ? "" : ", ") + k;
      throw UsageError("--methods " + list + ": '" + name + "' is none of " + all);
    }
    if (std::count(out.begin(), out.end(), name) == 0) out.push_back(name);
    begin = comma + 1;
  }
  return out;
}

/// Beside a published method, exactly what was published.
std::vector<std::string> with_published(std::vector<std::string> methods) {
  for (const char* name : {"thesis", "ahsan"}) {
    const std::string exact = std::string(name) + "-published";
    if (std::count(methods.begin(), methods.end(), name) > 0 &&
        std::count(methods.begin(), methods.end(), exact) == 0)
      methods.push_back(exact);
  }
  return methods;
}

void write_file(const fs::path& file, const std::string& text) {
  const fs::path part = file.string() + ".part";
  std::ofstream out(part, std::ios::binary | std::ios::trunc);
  out << text;
  out.close();
  if (!out) throw std::runtime_error(file.string() + ": cannot be written");
  fs::rename(part, file);
}

std::string read_file(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// What is known of each model so far, one file a model, so that an evaluation that was cut off goes on.
class Finished {
 public:
  /// `settings`: whatever the rows depend on but the model.
  Finished(fs::path folder, std::string settings)
      : folder_(std::move(folder)), settings_(std::move(settings)) {
    fs::create_directories(folder_);
  }
  std::vector<evaluate::Row> find(const CorpusModel& model) const {
    try {
      return evaluate::from_csv(read_file(file_of(model)));
    } catch (const std::exception&) {
      return {};  // cut off while it was written, or the model is gone: it is evaluated again and says why
    }
  }
  void keep(const CorpusModel& model, const std::vector<evaluate::Row>& rows) const {
    write_file(file_of(model), evaluate::to_csv(rows));
  }

 private:
  fs::path file_of(const CorpusModel& model) const {
    const std::string key = config::sha256_of(settings_ + "\n" + model.name + "\n" + fixed(model.scale, 9) +
                                              "\n" + config::sha256_of_file(model.file));
    std::string name = model.name;
    for (char& c : name)
      if (c == '/') c = '_';
    return folder_ / (name + "." + key.substr(0, 12) + ".csv");
  }
  fs::path folder_;
  std::string settings_;
};

std::vector<evaluate::Row> evaluate_model(const CorpusModel& model, evaluate::CompareOptions options,
                                          const run::Context& ctx) {
  try {
    options.prepare.import.scale *= model.scale;
    const auto import = mesh::import_model(model.file, options.prepare.import, ctx);
    return evaluate::compare(model.name, import.mesh, options, ctx);
  } catch (const run::Stopped&) {
    throw;
  } catch (const std::exception& e) {
    return {evaluate::failed(model.name, e.what())};
  }
}

std::string progress_text(const std::vector<evaluate::Row>& rows) {
  if (rows.front().method.empty()) return "left out: " + rows.front().why;
  std::string out;
  for (const auto& r : rows) {
    if (r.method.ends_with("-published")) continue;
    out += (out.empty() ? "" : ", ") + r.method + " " + (r.predicted_s ? duration_text(*r.predicted_s) : "–");
  }
  return out;
}

std::vector<evaluate::Row> evaluate_all(const std::vector<CorpusModel>& models, const Finished& finished,
                                        const evaluate::CompareOptions& options, unsigned jobs) {
  std::vector<std::vector<evaluate::Row>> rows(models.size());
  std::mutex mutex;
  std::size_t done = 0;
  run::Context ctx;
  ctx.threads = jobs;
  run::Context inner;
  // One model a thread; where there are fewer models than threads, each may use several.
  inner.threads =
      std::max(1U, ctx.thread_count() / static_cast<unsigned>(std::min<std::size_t>(models.size(), 1024)));
  run::parallel_for(ctx, models.size(), [&](std::size_t i) {
    rows[i] = finished.find(models[i]);
    const bool known = !rows[i].empty();
    if (!known) {
      rows[i] = evaluate_model(models[i], options, inner);
      if (!rows[i].front().method.empty()) finished.keep(models[i], rows[i]);
    }
    const std::lock_guard lock(mutex);
    std::fprintf(stderr, "[%zu/%zu] %s%s: %s\n", ++done, models.size(), models[i].name.c_str(),
                 known ? " (as before)" : "", progress_text(rows[i]).c_str());
  });
  std::vector<evaluate::Row> all;
  for (auto& r : rows) all.insert(all.end(), r.begin(), r.end());
  return all;
}

std::string settings_text(const Settings& s, const std::vector<std::string>& methods) {
  const auto& o = s.options;
  const auto& w = o.orient.weights;
  std::string out = std::string(daemon::version()) + "\n" + s.profile.sha256 + "\n" +
                    std::to_string(o.orient.subdivisions) + " " +
                    std::to_string(static_cast<int>(o.orient.critical)) + " " + fixed(w.h, 6) + " " +
                    fixed(w.v, 6) + " " + fixed(w.d, 6) + " " + fixed(w.c, 6) + " " +
                    fixed(o.import.scale, 9) + " " +
                    (o.max_extra ? std::to_string(*o.max_extra) : fixed(o.budget_s, 3) + " s");
  const auto& l = o.orient.limits;
  for (const double v :
       {l.min_contact_mm2, l.min_contact_share, l.stability_margin_mm, l.bed_margin_mm, o.limits.baud})
    out += " " + fixed(v, 6);
  for (const auto& m : methods) out += "\n" + m;
  return out;
}

std::vector<std::pair<std::string, std::string>> facts_of(const Settings& s, const std::string& corpus,
                                                          std::size_t models,
                                                          const std::vector<evaluate::Row>& rows,
                                                          double elapsed_s) {
  const auto& p = s.profile;
  const auto& o = s.options;
  std::size_t failed = 0;
  for (const auto& r : rows) failed += r.method.empty() ? 1U : 0U;
  return {{"models",
           std::to_string(models) + " in " + corpus + ", " + std::to_string(failed) + " of them left out"},
          {"profile", p.printer + ", " + p.material + ", " + p.quality + "; sha256 " + p.sha256},
          {"candidates", std::to_string(o.orient.subdivisions) +
                             " subdivisions, the six axes, the hull's resting faces; beyond the baselines " +
                             (o.max_extra ? std::to_string(*o.max_extra) + " timed"
                                          : "as many timed as fit in " + fixed(o.budget_s, 0) + " s") +
                             " by toolpath"},
          {"times", "this program's own slicer and planner, without heating"},
          {"took", duration_text(elapsed_s)},
          {"version", daemon::version()}};
}

}  // namespace

int evaluate_command(const std::vector<std::string>& args) {
  CLI::App app("Compares methods of choosing the orientation over many models", "evaluate");
  CommonFlags common;
  OrientFlags orient;
  std::string corpus, out, methods = "thesis,ahsan,toolpath,as-delivered,lowest,axes,tweaker";
  std::size_t extra = kExtra;
  app.add_option("corpus", corpus, "a folder of models, or a CSV file with a column 'file'")->required();
  app.add_option("--out", out, "the folder for evaluate.csv and index.html")->required();
  app.add_option("--methods", methods, "which, with commas between")->capture_default_str();
  app.add_option("--jobs", common.threads, "models at once");
  add_common(app, common);
  app.add_option("--subdivisions", orient.subdivisions, "samples 20*4^n directions and the six axes");
  app.add_option("--critical", orient.critical, "normals or morse: which heights bound the slabs");
  app.add_option("--weights", orient.weights, "h,v,d,c: by which toolpath ranks its candidates");
  auto* budget =
      app.add_option("--budget-s", orient.budget_s, "seconds that toolpath may take for each model")
          ->check(CLI::NonNegativeNumber);
  app.add_option("--extra", extra, "instead: how many candidates toolpath times beyond the baselines")
      ->capture_default_str()
      ->excludes(budget);
  if (!parse(app, args)) return 0;

  Settings s = settings_from(common, orient);
  evaluate::CompareOptions options;
  options.methods = with_published(methods_from(methods));
  options.now_s = s.options.now_s;
  if (orient.budget_s < 0) {
    s.options.max_extra = extra;
    s.options.now_s = nullptr;
  }
  options.prepare = s.options;
  const std::vector<CorpusModel> models = list_corpus(corpus);
  fs::create_directories(out);

  const double begin = options.now_s();
  const Finished finished(fs::path(out) / "models", settings_text(s, options.methods));
  const std::vector<evaluate::Row> rows = evaluate_all(models, finished, options, common.threads);
  const double elapsed = options.now_s() - begin;
  write_file(fs::path(out) / "evaluate.csv", evaluate::to_csv(rows));
  write_file(fs::path(out) / "index.html",
             evaluate::comparison_page(rows, facts_of(s, corpus, models.size(), rows, elapsed)));

  if (common.json) {
    const auto shares = evaluate::shares_of(evaluate::compare_methods(rows, "ahsan", "thesis").ratios);
    nlohmann::ordered_json medians = nlohmann::ordered_json::object();
    for (const auto& m : options.methods) {
      const auto pair = evaluate::compare_methods(rows, m, "toolpath");
      if (!pair.ratios.empty()) medians[m] = evaluate::quantile(pair.ratios, 0.5);
    }
    const nlohmann::ordered_json j = {{"models", models.size()},
                                      {"csv", (fs::path(out) / "evaluate.csv").string()},
                                      {"page", (fs::path(out) / "index.html").string()},
                                      {"four_against_three",
                                       {{"models", shares.count},
                                        {"equal", shares.equal},
                                        {"faster", shares.above},
                                        {"slower", shares.below}}},
                                      {"median_over_toolpath", medians},
                                      {"elapsed_s", elapsed}};
    std::cout << j.dump(2) << '\n';
  } else {
    std::printf("%s%s and evaluate.csv, in %s\n", evaluate::summary_text(rows).c_str(),
                (fs::path(out) / "index.html").c_str(), duration_text(elapsed).c_str());
  }
  return 0;
}

}  // namespace voidpath::cli
