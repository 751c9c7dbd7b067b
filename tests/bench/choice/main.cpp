#include "config/config.h"
#include "engine/mesh/import.h"
#include "engine/mesh/write.h"
#include "engine/orient/search.h"
#include "engine/pipeline/slice_part.h"
#include "engine/pipeline/time_candidates.h"
#include "tests/bench/choice/ranks.h"
#include "tests/bench/slicer/child.h"
#include "tests/bench/slicer/rival.h"
#include "tests/support/real_models.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <random>
#include <set>
#include <string>
#include <vector>

/// Does the order of directions hold with another slicer and estimator? Each model stands in the baselines'
/// directions, in the chosen one and in a few more; ours and PrusaSlicer slice and time all of them.
///   bench_choice [--models DIR] [--count N] [--seed N] [--directions N] [--profile SPEC] [--only TEXT]
/// The models are drawn from the folder by the seed, among those of at most kMostTriangles facets.
namespace {

namespace fs = std::filesystem;
using namespace voidpath;

/// PrusaSlicer takes minutes for larger ones, times a dozen directions.
constexpr std::size_t kMostTriangles = 30'000;
/// A slicing that takes longer is left out, s.
constexpr double kLimit_s = 300;
/// Candidates that our choice may time beyond the baselines: by number, so that the clock has no say.
constexpr std::size_t kExtra = 8;

struct Options {
  fs::path models;
  std::size_t count = 12;
  unsigned seed = 1;
  std::size_t directions = 8;
  std::string profile = "generic-marlin,pla,0.20mm";
  std::string only;
};

/// Limits that PrusaSlicer's estimate goes by: ours.
std::string machine_limits(const motion::MachineLimits& l) {
  std::string out = "machine_limits_usage = time_estimate_only\n";
  const auto add = [&](const std::string& key, double value) {
    out += key + " = " + std::to_string(value) + "," + std::to_string(value) + "\n";
  };
  const char* axes[] = {"x", "y", "z", "e"};
  const motion::PerAxis jerk = l.jerk_mm_s.value_or(motion::PerAxis{8, 8, 0.4, 5});
  for (std::size_t a = 0; a < 4; ++a) {
    add(std::string("machine_max_feedrate_") + axes[a], l.max_speed_mm_s[a]);
    add(std::string("machine_max_acceleration_") + axes[a], l.max_acceleration_mm_s2[a]);
    add(std::string("machine_max_jerk_") + axes[a], jerk[a]);
  }
  add("machine_max_acceleration_extruding", l.print_acceleration_mm_s2);
  add("machine_max_acceleration_retracting", l.retract_acceleration_mm_s2);
  add("machine_max_acceleration_travel", l.travel_acceleration_mm_s2);
  return out;
}

struct Result {
  std::string name;
  std::vector<double> ours, theirs;
  std::optional<double> correlation;
  double gain_ours = 0, gain_theirs = 0;  ///< chosen over as delivered: share of time saved
  bool compared = false;
};

class Bench {
 public:
  explicit Bench(const Options& options)
      : options_(options),
        profile_(config::load_profile(options.profile)),
        folder_(fs::temp_directory_path() / "voidpath-bench-choice") {
    fs::create_directories(folder_);
    std::string ini = bench::prusa_config(profile_.print);
    const std::string unlimited = "machine_limits_usage = ignore\n";
    if (const auto line = ini.find(unlimited); line != std::string::npos) ini.erase(line, unlimited.size());
    std::ofstream(folder_ / "rival.ini") << ini << machine_limits(profile_.limits);
    prepare_.print = profile_.print;
    prepare_.limits = profile_.limits;
    prepare_.limits.baud = 0;  // the rival knows nothing of the serial line
    prepare_.orient = config::search_options({}, profile_);
    prepare_.max_extra = kExtra;
  }

  Result run(const fs::path& model, double scale) const {
    mesh::ImportOptions import;
    import.scale = scale;
    const mesh::TriangleMesh mesh = mesh::import_model(model, import).mesh;
    if (mesh.triangles.size() > kMostTriangles) throw std::runtime_error("too many facets for this bench");
    const orient::Choice choice = pipeline::choose(mesh, prepare_, {});
    Result out;
    out.name = model.filename().string();
    std::vector<std::optional<double>> rival;
    const std::vector<std::size_t> which = directions(choice);
    for (const std::size_t i : which) {
      const orient::Candidate& c = choice.candidates[i];
      const double ours = c.predicted_s ? *c.predicted_s : pipeline::time_part(mesh, c, prepare_, {});
      rival.push_back(theirs(mesh, c));
      if (!rival.back()) continue;
      out.ours.push_back(ours);
      out.theirs.push_back(*rival.back());
    }
    out.correlation = bench::spearman(out.ours, out.theirs);
    const auto at = [&](std::size_t candidate) {
      return static_cast<std::size_t>(std::find(which.begin(), which.end(), candidate) - which.begin());
    };
    const auto& delivered = choice.candidates[choice.as_delivered];
    if (delivered.printable && delivered.predicted_s && rival[at(choice.chosen)] &&
        rival[at(choice.as_delivered)]) {
      out.compared = choice.chosen != choice.as_delivered;
      out.gain_ours = 1 - *choice.candidates[choice.chosen].predicted_s / *delivered.predicted_s;
      out.gain_theirs = 1 - *rival[at(choice.chosen)] / *rival[at(choice.as_delivered)];
    }
    return out;
  }

 private:
  /// The chosen, as delivered, then the baselines and others that were timed in full, unalike ones.
  std::vector<std::size_t> directions(const orient::Choice& choice) const {
    std::vector<std::size_t> out{choice.chosen};
    const auto add = [&](std::size_t i) {
      const auto& c = choice.candidates[i];
      if (!c.printable || out.size() >= options_.directions + 2) return;
      for (const std::size_t k : out)
        if (k == i || (choice.candidates[k].direction.dot(c.direction) > 0.99 &&
                       choice.candidates[k].turn_rad == c.turn_rad))
          return;
      out.push_back(i);
    };
    if (choice.candidates[choice.as_delivered].printable && choice.as_delivered != choice.chosen)
      out.push_back(choice.as_delivered);
    for (const auto& [name, i] : choice.baselines) add(i);
    for (std::size_t i = 0; i < choice.candidates.size(); ++i)
      if (choice.candidates[i].predicted_s && choice.candidates[i].turn_rad == 0) add(i);
    return out;
  }

  std::optional<double> theirs(const mesh::TriangleMesh& mesh, const orient::Candidate& c) const {
    mesh::TriangleMesh standing = mesh::turned(mesh, c.direction);
    if (c.turn_rad != 0)
      standing =
          mesh::rotated(standing, geom::Quaternion(Eigen::AngleAxisd(c.turn_rad, geom::Vec3::UnitZ())));
    const fs::path stl = folder_ / "part.stl", gcode = folder_ / "part.gcode";
    mesh::write_model(standing, stl);
    fs::remove(gcode);
    const auto& m = profile_.print.machine;
    const std::string centre =
        m.origin_at_centre ? "0,0" : std::to_string(m.bed_mm[0] / 2) + "," + std::to_string(m.bed_mm[1] / 2);
    const auto usage =
        bench::run_child({"prusa-slicer", "--export-gcode", "--load", (folder_ / "rival.ini").string(),
                          "--dont-arrange", "--center", centre, "-o", gcode.string(), stl.string()},
                         folder_ / "rival.log", kLimit_s);
    return usage.ok ? bench::rival_estimate(gcode.string()) : std::nullopt;
  }

  Options options_;
  config::Profile profile_;
  fs::path folder_;
  pipeline::PrepareOptions prepare_;
};

Options parse(int argc, char** argv) {
  Options out;
  if (const char* shared = std::getenv("VOIDPATH_SHARED")) out.models = fs::path(shared) / "models";
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string word = argv[i], value = argv[i + 1];
    if (word == "--models")
      out.models = value;
    else if (word == "--count")
      out.count = std::stoul(value);
    else if (word == "--seed")
      out.seed = static_cast<unsigned>(std::stoul(value));
    else if (word == "--directions")
      out.directions = std::stoul(value);
    else if (word == "--profile")
      out.profile = value;
    else if (word == "--only")
      out.only = value;
    else
      throw std::invalid_argument(word + ": not understood");
  }
  return out;
}

double median(std::vector<double> v) {
  if (v.empty()) return 0;
  std::sort(v.begin(), v.end());
  return v.size() % 2 == 1 ? v[v.size() / 2] : 0.5 * (v[v.size() / 2 - 1] + v[v.size() / 2]);
}

}  // namespace

int main(int argc, char** argv) try {
  const Options options = parse(argc, argv);
  std::vector<test::RealModel> models = test::real_models(options.models, options.only);
  std::mt19937 random(options.seed);
  for (std::size_t i = models.size(); i > 1; --i) std::swap(models[i - 1], models[random() % i]);

  const Bench bench(options);
  std::printf("%-44s %5s %9s %10s %10s\n", "model", "dirs", "spearman", "ours", "theirs");
  std::vector<double> correlations;
  std::size_t done = 0, compared = 0, better = 0, not_worse = 0;
  for (const auto& [model, scale] : models) {
    if (done >= options.count) break;
    try {
      const Result r = bench.run(model, scale);
      ++done;
      if (r.correlation) correlations.push_back(*r.correlation);
      std::printf("%-44.44s %5zu %9s", r.name.c_str(), r.ours.size(),
                  r.correlation ? std::to_string(*r.correlation).substr(0, 6).c_str() : "-");
      if (r.compared) {
        ++compared;
        better += r.gain_theirs > 0 ? 1U : 0U;
        not_worse += r.gain_theirs > -0.001 ? 1U : 0U;
        std::printf(" %8.1f %% %8.1f %%", 100 * r.gain_ours, 100 * r.gain_theirs);
      }
      std::printf("\n");
    } catch (const std::exception& e) {
      std::printf("%-44.44s left out: %s\n", model.filename().c_str(), e.what());
    }
    std::fflush(stdout);
  }
  double mean = 0;
  for (const double c : correlations) mean += c / static_cast<double>(correlations.size());
  std::printf(
      "%zu models drawn with seed %u; rank correlation of the two slicers' times: median %.2f, mean %.2f "
      "over "
      "%zu models\n",
      done, options.seed, median(correlations), mean, correlations.size());
  std::printf(
      "our choice against as delivered where they differ, by the other slicer: faster in %zu, not slower in "
      "%zu "
      "of %zu models\n",
      better, not_worse, compared);
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "bench_choice: %s\n", e.what());
  return 1;
}
