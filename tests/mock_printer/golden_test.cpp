#include "tests/mock_printer/mock_marlin.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

using namespace voidpath::test::mock;

namespace {

std::string golden_dir() {
  const char* shared = std::getenv("VOIDPATH_SHARED");
  return shared == nullptr || *shared == 0 ? std::string() : std::string(shared) + "/planner-golden/";
}

struct ClosePipe {
  void operator()(FILE* f) const { ::pclose(f); }
};

struct GoldenRow {
  std::string name;
  double junction_s, jerk_s;
  std::uint64_t blocks;
};

std::vector<GoldenRow> golden_rows() {
  std::ifstream file(golden_dir() + "times.csv");
  std::string line;
  std::getline(file, line);
  std::vector<GoldenRow> rows;
  while (std::getline(file, line)) {
    for (char& c : line)
      if (c == ',') c = ' ';
    std::istringstream in(line);
    GoldenRow row;
    if (in >> row.name >> row.junction_s >> row.jerk_s >> row.blocks) rows.push_back(row);
  }
  return rows;
}

/// Seconds of the printer's clock from @begin to @end, one line in flight on a wire that costs nothing.
double print_seconds(const std::string& name, bool classic_jerk) {
  const std::string command = "xzcat '" + golden_dir() + name + ".gcode.xz'";
  const std::unique_ptr<FILE, ClosePipe> pipe(::popen(command.c_str(), "r"));
  MotionSettings motion;
  motion.classic_jerk = classic_jerk;
  MockMarlin printer(make_mock().motion(motion).cold_extrusion().build());
  printer.take_output();
  double begin = NAN, end = NAN;
  char line[256];
  while (std::fgets(line, sizeof line, pipe.get()) != nullptr) {
    const std::string_view text = line;
    if (text.starts_with("@begin")) begin = printer.now();
    if (text.starts_with("@end")) end = printer.now();
    if (text.starts_with("@")) continue;
    printer.feed(text);
    while (printer.take_output().find("ok\n") == std::string::npos) printer.advance_to(printer.next_event());
  }
  CHECK(printer.statistics().unknown == 0);
  return end - begin;
}

}  // namespace

TEST_CASE("prints take as long as on the real firmware", "[golden]") {
  if (golden_dir().empty()) {
    WARN("VOIDPATH_SHARED is not set: skipped");
    return;
  }
  const auto rows = golden_rows();
  REQUIRE(rows.size() >= 12);
  for (const bool classic_jerk : {false, true}) {
    double sum = 0;
    for (const GoldenRow& row : rows) {
      const double expected = classic_jerk ? row.jerk_s : row.junction_s;
      const double error = print_seconds(row.name, classic_jerk) / expected - 1;
      CAPTURE(row.name, classic_jerk, error);
      std::printf("%-28s %s %+.4f %%\n", row.name.c_str(), classic_jerk ? "jerk" : "jd", error * 100);
      CHECK(std::abs(error) < 0.002);
      sum += std::abs(error);
    }
    CHECK(sum / static_cast<double>(rows.size()) < 0.0006);
  }
}
