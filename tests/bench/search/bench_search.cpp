#include "engine/mesh/import.h"
#include "engine/orient/search.h"
#include "tests/bench/search/growing.h"
#include "tests/support/real_models.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <sys/resource.h>

/// Times the full search (1286 directions, four criteria) against PrusaSlicer slicing the same part once at
/// 0.2 mm with supports, in one run on one machine.
///
///   bench_search [--alone]            all parts of $VOIDPATH_SHARED/models, then --growth
///   bench_search [--alone] FILE...    these; of a folder with a MANIFEST.csv scaled as that says
///   bench_search --growth             one shape of 10 thousand, 100 thousand and a million triangles
///
/// The search is timed from the imported mesh, PrusaSlicer from its start, as a user waits for either;
/// --alone leaves PrusaSlicer out. Where other programs keep the processors busy, CPU time tells more than
/// the clock. Parts smaller or larger than a printer are scaled as the folder's MANIFEST.csv says.
namespace {

using Clock = std::chrono::steady_clock;
namespace fs = std::filesystem;

/// What a piece of work took: seconds by the clock and seconds of processor time.
struct Cost {
  double wall_s = 0;
  double cpu_s = 0;
};

double cpu_seconds(int who) {
  rusage usage{};
  getrusage(who, &usage);
  auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// `who`: RUSAGE_SELF or RUSAGE_CHILDREN, whoever does the work.
template <class Work>
Cost cost_of(int who, const Work& work) {
  const auto start = Clock::now();
  const double cpu = cpu_seconds(who);
  work();
  return {std::chrono::duration<double>(Clock::now() - start).count(), cpu_seconds(who) - cpu};
}

using Part = voidpath::test::RealModel;

std::vector<Part> shared_parts() {
  const char* shared = std::getenv("VOIDPATH_SHARED");
  return shared == nullptr ? std::vector<Part>() : voidpath::test::real_models(fs::path(shared) / "models");
}

std::string quoted(const fs::path& p) {
  std::string out = "'";
  for (const char c : p.string()) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// Nothing when PrusaSlicer is not there or cannot slice the part.
std::optional<Cost> slice_with_prusa(const Part& part, const fs::path& scratch) {
  const std::string command =
      "prusa-slicer --export-gcode --support-material --layer-height 0.2 --bed-shape "
      "0x0,1000x0,1000x1000,0x1000 "
      "--max-print-height 1000 --scale " +
      std::to_string(part.scale) + " -o " + quoted(scratch / "out.gcode") + " " + quoted(part.file) +
      " >/dev/null 2>&1";
  int status = 0;
  const Cost cost = cost_of(RUSAGE_CHILDREN, [&] { status = std::system(command.c_str()); });
  return status == 0 ? std::optional(cost) : std::nullopt;
}

Cost search(const voidpath::mesh::TriangleMesh& mesh) {
  voidpath::orient::SearchOptions options;
  options.method = voidpath::orient::Method::thesis;
  return cost_of(RUSAGE_SELF, [&] { voidpath::orient::search(mesh, options); });
}

void print_ratios(const char* name, std::vector<double> ratios) {
  if (ratios.empty()) return;
  std::sort(ratios.begin(), ratios.end());
  std::printf("%s: median %.3f, largest %.3f over %zu parts\n", name, ratios[ratios.size() / 2],
              ratios.back(), ratios.size());
}

void print_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("most memory: %ld MB\n", usage.ru_maxrss / 1024);
}

void compare(const std::vector<Part>& parts, bool alone) {
  const fs::path scratch =
      fs::temp_directory_path() / ("bench_search." + std::to_string(Clock::now().time_since_epoch().count()));
  fs::create_directories(scratch);
  std::printf("%-58s %9s %9s %9s %9s %9s %7s %9s\n", "part", "triangles", "search s", "CPU s", "prusa s",
              "CPU s", "ratio", "CPU ratio");
  std::vector<double> ratios;
  std::vector<double> of_medium;  ///< ratios for parts of 5 to 200 thousand triangles
  std::vector<double> cpu_ratios;
  double sum_s = 0;
  for (const Part& part : parts) {
    try {
      voidpath::mesh::ImportOptions import;
      import.scale = part.scale;
      const auto mesh = voidpath::mesh::import_model(part.file, import).mesh;
      const Cost ours = search(mesh);
      sum_s += ours.cpu_s;
      std::printf("%-58s %9zu %9.3f %9.3f", part.file.filename().c_str(), mesh.triangles.size(), ours.wall_s,
                  ours.cpu_s);
      if (const auto prusa = alone ? std::nullopt : slice_with_prusa(part, scratch)) {
        ratios.push_back(ours.wall_s / prusa->wall_s);
        cpu_ratios.push_back(ours.cpu_s / prusa->cpu_s);
        if (mesh.triangles.size() >= 5000 && mesh.triangles.size() <= 200000)
          of_medium.push_back(ratios.back());
        std::printf(" %9.2f %9.2f %7.3f %9.3f", prusa->wall_s, prusa->cpu_s, ratios.back(),
                    cpu_ratios.back());
      }
      std::printf("\n");
    } catch (const std::exception& e) {
      std::printf("%-58s %s\n", part.file.filename().c_str(), e.what());
    }
    std::fflush(stdout);
  }
  fs::remove_all(scratch);
  print_ratios("ratio", ratios);
  print_ratios("ratio, 5 to 200 thousand triangles", of_medium);
  print_ratios("ratio of CPU times", cpu_ratios);
  std::printf("CPU time of all searches: %.2f s\n", sum_s);
  print_memory();
}

void grow() {
  std::printf("%-58s %9s %9s %9s %20s\n", "the same shape, finer", "triangles", "search s", "CPU s",
              "CPU us per triangle");
  for (const std::size_t triangles : {std::size_t{10000}, std::size_t{100000}, std::size_t{1000000}}) {
    const auto mesh = voidpath::bench::rippled_ball(triangles);
    const Cost cost = search(mesh);
    const auto n = static_cast<double>(mesh.triangles.size());
    std::printf("%-58s %9zu %9.3f %9.3f %20.2f\n", "rippled ball", mesh.triangles.size(), cost.wall_s,
                cost.cpu_s, 1e6 * cost.cpu_s / n);
    std::fflush(stdout);
  }
  print_memory();
}

}  // namespace

int main(int argc, char** argv) {
  bool alone = false;
  bool growth = false;
  std::vector<Part> parts;
  for (int i = 1; i < argc; ++i) {
    const std::string arg = argv[i];
    if (arg == "--alone") {
      alone = true;
    } else if (arg == "--growth") {
      growth = true;
    } else {
      parts.push_back(voidpath::test::real_model(arg));
    }
  }
  if (parts.empty() && !growth) {
    parts = shared_parts();
    growth = true;
    if (parts.empty()) std::puts("no parts: set VOIDPATH_SHARED or name files");
  }
  if (!parts.empty()) compare(parts, alone);
  if (growth) grow();
}
