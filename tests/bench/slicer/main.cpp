#include "config/config.h"
#include "daemon/slicer/cura_settings.h"
#include "engine/mesh/import.h"
#include "engine/mesh/write.h"
#include "engine/pipeline/slice_part.h"
#include "engine/slice/layer_heights.h"
#include "engine/slice/slice_mesh.h"
#include "engine/toolpath/build.h"
#include "tests/bench/slicer/child.h"
#include "tests/bench/slicer/measure.h"
#include "tests/bench/slicer/rival.h"
#include "tests/support/real_models.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

/// Our slicer against PrusaSlicer and CuraEngine: the same meshes as delivered, the same settings, each a
/// program of its own from file to file, every G-code timed by our estimator. Models of a folder with a
/// MANIFEST.csv are scaled as that says.
///   bench_slicer [FILE...] [--models DIR] [--only TEXT] [--rival NAME] [--profile SPEC] [--set KEY=VALUE]
///                [--cura-definition FILE] [--keep DIR] [--reuse]
/// --keep: where models and G-code go, kept afterwards; --reuse: the rivals' G-code and times found there
/// are taken from their last run.
namespace {

namespace fs = std::filesystem;
using namespace voidpath;

/// A slicer that takes longer than this has lost, s.
constexpr double kLimitS = 600;

struct Options {
  std::vector<fs::path> files;
  fs::path models;
  std::vector<std::string> rivals = {"prusa", "cura"};
  fs::path cura_definition;
  std::vector<std::pair<std::string, std::string>> set;
  std::string only;
  std::string profile = "generic-marlin,pla,0.20mm";
  fs::path keep;
  bool reuse = false;
};

struct Run {
  bench::Usage usage;
  bench::Print print;
};

struct Row {
  std::string name;
  Run ours;
  Run theirs;
};

std::string title(const std::string& rival) { return rival == "prusa" ? "PrusaSlicer" : "CuraEngine"; }

class Bench {
 public:
  Bench(Options options, fs::path bin)
      : options_(std::move(options)),
        bin_(std::move(bin)),
        profile_(config::load_profile(options_.profile, options_.set)) {
    fs::create_directories(options_.keep);
    std::ofstream(options_.keep / "rival.ini") << bench::prusa_config(profile_.print);
  }

  /// A row for each rival; none for what is no model or does not fit.
  std::vector<Row> run(const test::RealModel& model) {
    Row row;
    row.name = model.file.stem().string();
    const fs::path base = options_.keep / row.name;
    mesh::Bounds bounds;
    const fs::path stl = base.string() + ".stl";
    slice::LayerStack stack;
    double brim_mm = profile_.print.slice.brim_width_mm;
    try {
      mesh::ImportOptions import;
      import.scale = model.scale;
      mesh::TriangleMesh mesh =
          mesh::turned(mesh::import_model(model.file, import).mesh, geom::Vec3(0, 0, 1));
      const geom::Vec3 size = mesh::bounds(mesh).size();
      const auto& m = profile_.print.machine;
      if (size.x() > m.bed_mm[0] || size.y() > m.bed_mm[1] || size.z() > m.height_mm) return {};
      bounds = mesh::bounds(mesh);
      mesh::write_model(mesh, stl);
      brim_mm = held_by(mesh);
      const auto& s = profile_.print.slice;
      stack =
          slice::slice_mesh(mesh, slice::equal_layers(size.z(), s.first_layer_height_mm, s.layer_height_mm));
      toolpath::place_on_bed(stack, m);
    } catch (const mesh::ImportError&) {
      return {};
    }
    std::vector<std::string> ours = {
        (bin_ / "voidpath").string(),  "slice",          stl.string(), "-o",
        base.string() + ".ours.gcode", "--as-delivered", "--profile",  options_.profile};
    for (const auto& [key, value] : options_.set) ours.insert(ours.end(), {"--set", key + "=" + value});
    row.ours = slice(ours, base.string() + ".ours", stack, false);
    std::vector<Row> rows;
    for (const std::string& rival : options_.rivals) {
      const std::string out = base.string() + "." + rival + (brim_mm > 0 ? ".brim" : "");
      row.theirs = slice(rival == "prusa" ? prusa(stl, out, brim_mm) : cura(stl, out, bounds, brim_mm), out,
                         stack, options_.reuse);
      rows.push_back(row);
    }
    return rows;
  }

 private:
  /// Width of the brim that we print: a part that does not stand by itself is held by one, and the rival's
  /// is to be held as well.
  double held_by(const mesh::TriangleMesh& mesh) const {
    pipeline::PrepareOptions options;
    options.print = profile_.print;
    options.limits = profile_.limits;
    options.orient.method = orient::Method::as_delivered;
    const orient::Choice choice = pipeline::choose(mesh, options, {});
    return pipeline::held(options, choice.candidates[choice.chosen]).print.slice.brim_width_mm;
  }

  std::vector<std::string> prusa(const fs::path& stl, const std::string& out, double brim_mm) const {
    std::vector<std::string> command = {
        "prusa-slicer",   "--export-gcode", "--load", (options_.keep / "rival.ini").string(),
        "--dont-arrange", "--center",       centre(), "-o",
        out + ".gcode"};
    if (brim_mm > 0)
      for (const std::string& word : {std::string("--brim-type"), std::string("outer_only"),
                                      std::string("--brim-width"), std::to_string(brim_mm)})
        command.push_back(word);
    command.push_back(stl.string());
    return command;
  }

  std::vector<std::string> cura(const fs::path& stl, const std::string& out, const mesh::Bounds& bounds,
                                double brim_mm) const {
    toolpath::PrintSettings print = profile_.print;
    print.slice.brim_width_mm = brim_mm;
    daemon::CuraSettings settings = daemon::cura_settings(print);
    for (const auto& [key, value] : daemon::cura_start_and_end(print, settings, bounds))
      settings[key] = value;
    settings["center_object"] = "false";
    const std::string folder = options_.cura_definition.parent_path().string();
    std::vector<std::string> command = {
        "env",        "CURA_ENGINE_SEARCH_PATH=" + folder + ":" + folder + "/../extruders",
        "CuraEngine", "slice",
        "-j",         options_.cura_definition.string(),
        "-o",         out + ".gcode"};
    for (std::string& word : daemon::cura_arguments(settings)) command.push_back(std::move(word));
    command.insert(command.end(), {"-l", stl.string()});
    return command;
  }

  std::string centre() const {
    const auto& m = profile_.print.machine;
    if (m.origin_at_centre) return "0,0";
    return std::to_string(m.bed_mm[0] / 2) + "," + std::to_string(m.bed_mm[1] / 2);
  }

  Run slice(const std::vector<std::string>& command, const std::string& base, const slice::LayerStack& stack,
            bool reuse) const {
    Run out;
    const fs::path usage_file = base + ".usage";
    if (reuse && fs::exists(usage_file)) {
      std::ifstream in(usage_file);
      in >> out.usage.ok >> out.usage.wall_s >> out.usage.cpu_s >> out.usage.peak_mb;
    } else {
      out.usage = bench::run_child(command, base + ".log", kLimitS);
      std::ofstream(usage_file) << out.usage.ok << ' ' << out.usage.wall_s << ' ' << out.usage.cpu_s << ' '
                                << out.usage.peak_mb << '\n';
    }
    if (out.usage.ok) out.print = bench::measure(base + ".gcode", stack, profile_.limits);
    return out;
  }

  Options options_;
  fs::path bin_;
  config::Profile profile_;
};

double ratio(double ours, double theirs) { return theirs > 0 ? ours / theirs : ours > 0 ? 99 : 1; }

/// Quotients ours : theirs of one model.
struct Quotients {
  double wall, cpu, memory, time, filament, travel, outside, retractions;
};

Quotients quotients(const Row& row) {
  const auto &a = row.ours, &b = row.theirs;
  return {ratio(a.usage.wall_s, b.usage.wall_s),
          ratio(a.usage.cpu_s, b.usage.cpu_s),
          ratio(a.usage.peak_mb, b.usage.peak_mb),
          ratio(a.print.seconds, b.print.seconds),
          ratio(a.print.filament_m, b.print.filament_m),
          ratio(a.print.travel_m, b.print.travel_m),
          ratio(a.print.travel_outside_m, b.print.travel_outside_m),
          ratio(static_cast<double>(a.print.retractions), static_cast<double>(b.print.retractions))};
}

void print_line(const std::string& name, const Quotients& q, const std::string& note) {
  std::printf("%-34.34s %6.3f %6.3f %6.2f %7.3f %7.3f %7.3f %7.3f %7.2f  %s\n", name.c_str(), q.wall, q.cpu,
              q.memory, q.time, q.filament, q.travel, q.outside, q.retractions, note.c_str());
}

std::string absolutes(const Row& row) {
  char text[160];
  std::snprintf(text, sizeof text, "%6.2f %6.2f s | %7.0f %7.0f s | %6zu %6zu retr | %7zu %7zu moves",
                row.ours.usage.wall_s, row.theirs.usage.wall_s, row.ours.print.seconds,
                row.theirs.print.seconds, row.ours.print.retractions, row.theirs.print.retractions,
                row.ours.print.moves, row.theirs.print.moves);
  return text;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

void summarise(const std::string& rival, const std::vector<Row>& rows) {
  if (rows.empty()) return;
  std::printf("ours : %s\n", title(rival).c_str());
  std::vector<Quotients> all;
  double ours = 0, theirs = 0, print_ours = 0, print_theirs = 0;
  for (const Row& row : rows) {
    all.push_back(quotients(row));
    ours += row.ours.usage.wall_s, theirs += row.theirs.usage.wall_s;
    print_ours += row.ours.print.seconds, print_theirs += row.theirs.print.seconds;
  }
  auto of = [&](double Quotients::*member, bool worst) {
    std::vector<double> values;
    for (const auto& q : all) values.push_back(q.*member);
    return worst ? *std::max_element(values.begin(), values.end()) : median(values);
  };
  for (const bool worst : {false, true})
    print_line(worst ? "worst" : "median",
               {of(&Quotients::wall, worst), of(&Quotients::cpu, worst), of(&Quotients::memory, worst),
                of(&Quotients::time, worst), of(&Quotients::filament, worst), of(&Quotients::travel, worst),
                of(&Quotients::outside, worst), of(&Quotients::retractions, worst)},
               "");
  std::printf(
      "%zu models: slicing %.1f s against %.1f s (%.1f times as fast); printing %.1f h against %.1f h\n",
      rows.size(), ours, theirs, theirs / ours, print_ours / 3600, print_theirs / 3600);
}

Options parse(int argc, char** argv) {
  Options out;
  if (const char* file = std::getenv("VOIDPATH_CURA_DEFINITION"); file != nullptr) out.cura_definition = file;
  const char* shared = std::getenv("VOIDPATH_SHARED");
  if (shared != nullptr) out.models = fs::path(shared) / "models";
  out.keep = fs::temp_directory_path() / "voidpath-bench-slicer";
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool has_value = i + 1 < argc;
    if (word == "--reuse")
      out.reuse = true;
    else if (!word.starts_with("--"))
      out.files.emplace_back(word);
    else if (word == "--rival" && has_value)
      out.rivals = {argv[++i]};
    else if (word == "--cura-definition" && has_value)
      out.cura_definition = argv[++i];
    else if (word == "--set" && has_value) {
      const std::string pair = argv[++i];
      out.set.emplace_back(pair.substr(0, pair.find('=')), pair.substr(pair.find('=') + 1));
    } else if (word == "--models" && has_value)
      out.models = argv[++i];
    else if (word == "--only" && has_value)
      out.only = argv[++i];
    else if (word == "--profile" && has_value)
      out.profile = argv[++i];
    else if (word == "--keep" && has_value)
      out.keep = argv[++i];
    else
      throw std::invalid_argument(word + ": not understood");
  }
  for (const std::string& rival : out.rivals)
    if (rival != "prusa" && rival != "cura")
      throw std::invalid_argument("--rival " + rival + ": prusa or cura");
  if (out.cura_definition.empty()) {
    std::fprintf(stderr, "no --cura-definition: without CuraEngine\n");
    std::erase(out.rivals, "cura");
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) try {
  const Options options = parse(argc, argv);
  if (options.files.empty() && !fs::is_directory(options.models)) {
    std::fprintf(stderr, "no models: give --models DIR or set VOIDPATH_SHARED\n");
    return 2;
  }
  std::vector<test::RealModel> models;
  for (const fs::path& file : options.files) models.push_back(test::real_model(file));
  if (models.empty()) models = test::real_models(options.models, options.only);

  Bench bench(options, fs::canonical("/proc/self/exe").parent_path());
  std::printf(
      "ours : theirs                        wall    cpu memory    time filament travel outside  retr.\n");
  std::map<std::string, std::vector<Row>> rows;
  for (const test::RealModel& model : models) {
    const std::vector<Row> found = bench.run(model);
    for (std::size_t i = 0; i < found.size(); ++i) {
      const Row& row = found[i];
      const std::string& rival = options.rivals[i];
      if (!row.ours.usage.ok || !row.theirs.usage.ok) {
        std::printf("%-34.34s %s failed\n", row.name.c_str(),
                    row.ours.usage.ok ? title(rival).c_str() : "ours");
        continue;
      }
      print_line(i == 0 ? row.name : "  beside " + title(rival), quotients(row), absolutes(row));
      std::fflush(stdout);
      rows[rival].push_back(row);
    }
  }
  for (const std::string& rival : options.rivals) summarise(rival, rows[rival]);
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "bench_slicer: %s\n", e.what());
  return 1;
}
