#include "engine/mesh/import.h"
#include "engine/orient/search.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <sys/resource.h>

/// Times the full search (1286 directions, four criteria) against PrusaSlicer slicing the same part once at
/// 0.2 mm with supports, in one run on one machine.
///
///   bench_search            all parts of $VOIDPATH_SHARED/models
///   bench_search FILE...    these
///
/// The search is timed from the imported mesh, PrusaSlicer from its start, as a user waits for either. Parts
/// smaller or larger than a printer are scaled as the folder's MANIFEST.csv says.
namespace {

using Clock = std::chrono::steady_clock;
namespace fs = std::filesystem;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Part {
  fs::path file;
  double scale = 1;
};

std::vector<std::string> split_csv(const std::string& line) {
  std::vector<std::string> out(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      out.emplace_back();
    } else {
      out.back() += c;
    }
  }
  return out;
}

std::vector<Part> shared_parts() {
  std::vector<Part> out;
  const char* shared = std::getenv("VOIDPATH_SHARED");
  if (shared == nullptr) return out;
  const fs::path folder = fs::path(shared) / "models";
  std::ifstream manifest(folder / "MANIFEST.csv");
  std::string line;
  std::getline(manifest, line);
  const auto header = split_csv(line);
  const auto column =
      static_cast<std::size_t>(std::find(header.begin(), header.end(), "scale") - header.begin());
  while (std::getline(manifest, line)) {
    const auto fields = split_csv(line);
    if (column >= fields.size()) continue;
    Part part{folder / fields[0], 1};
    std::from_chars(fields[column].data(), fields[column].data() + fields[column].size(), part.scale);
    if (voidpath::mesh::is_model_name(part.file)) out.push_back(part);
  }
  return out;
}

std::string quoted(const fs::path& p) {
  std::string out = "'";
  for (const char c : p.string()) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// Seconds, negative when PrusaSlicer is not there or cannot slice the part.
double slice_with_prusa(const Part& part, const fs::path& scratch) {
  const std::string command =
      "prusa-slicer --export-gcode --support-material --layer-height 0.2 --bed-shape "
      "0x0,1000x0,1000x1000,0x1000 "
      "--max-print-height 1000 --scale " +
      std::to_string(part.scale) + " -o " + quoted(scratch / "out.gcode") + " " + quoted(part.file) +
      " >/dev/null 2>&1";
  const auto start = Clock::now();
  const int status = std::system(command.c_str());
  return status == 0 ? seconds_since(start) : -1;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<Part> parts;
  for (int i = 1; i < argc; ++i) parts.push_back({argv[i], 1});
  if (parts.empty()) parts = shared_parts();
  if (parts.empty()) {
    std::puts("no parts: set VOIDPATH_SHARED or name files");
    return 2;
  }
  const fs::path scratch =
      fs::temp_directory_path() / ("bench_search." + std::to_string(Clock::now().time_since_epoch().count()));
  fs::create_directories(scratch);
  std::printf("%-58s %9s %9s %9s %7s\n", "part", "triangles", "search s", "prusa s", "ratio");
  std::vector<double> ratios;
  for (const Part& part : parts) {
    try {
      voidpath::mesh::ImportOptions import;
      import.scale = part.scale;
      const auto mesh = voidpath::mesh::import_model(part.file, import).mesh;
      voidpath::orient::SearchOptions options;
      options.method = voidpath::orient::Method::thesis;
      const auto start = Clock::now();
      voidpath::orient::search(mesh, options);
      const double search_s = seconds_since(start);
      const double prusa_s = slice_with_prusa(part, scratch);
      std::printf("%-58s %9zu %9.2f ", part.file.filename().c_str(), mesh.triangles.size(), search_s);
      if (prusa_s > 0) {
        ratios.push_back(search_s / prusa_s);
        std::printf("%9.2f %7.2f\n", prusa_s, ratios.back());
      } else {
        std::printf("%9s %7s\n", "-", "-");
      }
    } catch (const std::exception& e) {
      std::printf("%-58s %s\n", part.file.filename().c_str(), e.what());
    }
    std::fflush(stdout);
  }
  fs::remove_all(scratch);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  if (!ratios.empty()) {
    std::sort(ratios.begin(), ratios.end());
    std::printf("ratio: median %.3f, largest %.3f over %zu parts\n", ratios[ratios.size() / 2], ratios.back(),
                ratios.size());
  }
  std::printf("most memory: %ld MB\n", usage.ru_maxrss / 1024);
}
