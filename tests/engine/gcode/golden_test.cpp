#include "engine/gcode/estimate.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <istream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

using namespace voidpath;

namespace {

struct Golden {
  std::string name;
  double deviation_s = 0;  ///< measured with junction deviation
  double jerk_s = 0;       ///< with classic jerk
};

std::filesystem::path golden_dir() {
  const char* shared = std::getenv("VOIDPATH_SHARED");
  return shared == nullptr ? std::filesystem::path() : std::filesystem::path(shared) / "planner-golden";
}

std::vector<Golden> golden_list() {
  std::ifstream in(golden_dir() / "times.csv");
  std::vector<Golden> out;
  std::string line;
  std::getline(in, line);  // header
  while (std::getline(in, line)) {
    std::istringstream fields(line);
    Golden golden;
    std::string jd;
    std::string cj;
    if (std::getline(fields, golden.name, ',') && std::getline(fields, jd, ',') &&
        std::getline(fields, cj, ',')) {
      golden.deviation_s = std::stod(jd);
      golden.jerk_s = std::stod(cj);
      out.push_back(golden);
    }
  }
  return out;
}

std::string unpacked(const std::filesystem::path& file) {
  const std::string command = "xz -dc '" + file.string() + "'";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string text;
  std::array<char, 65536> piece;
  while (pipe) {
    const std::size_t got = std::fread(piece.data(), 1, piece.size(), pipe.get());
    if (got == 0) break;
    text.append(piece.data(), got);
  }
  return text;
}

gcode::Estimate timed(const std::string& text, bool jerk) {
  motion::MachineLimits limits;
  if (jerk) limits.jerk_mm_s = motion::PerAxis{8, 8, 0.4, 5};
  std::istringstream in(text);
  return gcode::estimate(in, limits);
}

}  // namespace

TEST_CASE("measured prints are predicted", "[gcode][golden]") {
  const std::vector<Golden> list = golden_dir().empty() ? std::vector<Golden>() : golden_list();
  if (list.empty()) {
    WARN("skipped: measured prints are not at hand (VOIDPATH_SHARED)");
    return;
  }
  double sum = 0;
  double worst = 0;
  std::size_t count = 0;
  for (const Golden& golden : list) {
    const std::string text = unpacked(golden_dir() / (golden.name + ".gcode.xz"));
    INFO(golden.name);
    REQUIRE(text.size() > 1000);
    for (const bool jerk : {false, true}) {
      const double measured = jerk ? golden.jerk_s : golden.deviation_s;
      const double error = std::abs(timed(text, jerk).predicted_s / measured - 1);
      sum += error;
      worst = std::max(worst, error);
      ++count;
    }
  }
  CHECK(sum / static_cast<double>(count) <= 0.0005);
  CHECK(worst <= 0.0015);
}

TEST_CASE("G-code is timed at half a million lines a second", "[.bench]") {
  const std::vector<Golden> list = golden_dir().empty() ? std::vector<Golden>() : golden_list();
  if (list.empty()) {
    WARN("skipped: measured prints are not at hand (VOIDPATH_SHARED)");
    return;
  }
  std::size_t lines = 0;
  double seconds = 0;
  for (const Golden& golden : list) {
    const std::string text = unpacked(golden_dir() / (golden.name + ".gcode.xz"));
    const auto start = std::chrono::steady_clock::now();
    lines += timed(text, false).lines;
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  WARN(static_cast<double>(lines) / seconds << " lines/s");
  CHECK(static_cast<double>(lines) / seconds >= 500'000);
}
