#include "engine/gcode/progress.h"

#include "engine/gcode/estimate.h"

#include <cmath>
#include <sstream>
#include <string>

#include <catch2/catch.hpp>

using namespace voidpath;

namespace {

std::string with_progress(const std::string& text) {
  std::istringstream in(text);
  std::ostringstream out;
  gcode::add_progress(in, out, {});
  return out.str();
}

}  // namespace

TEST_CASE("progress goes from 0 to 100 percent by the planner's time and changes nothing else") {
  std::string text = "G21\nG90\nM83\n; a comment\n";
  for (int i = 0; i < 400; ++i) text += "G1 X" + std::to_string(i % 2 == 0 ? 100 : 0) + " E1 F3000\n";
  text += "M104 S0\n";
  std::istringstream plain(text);
  const double total = gcode::estimate(plain, {}).predicted_s;
  CHECK(total > 600);

  std::istringstream lines(with_progress(text));
  std::string stripped, line, first, last;
  int percent = -1, minutes = 1 << 20;
  std::size_t marks = 0;
  while (std::getline(lines, line)) {
    if (line.rfind("M73 P", 0) != 0) {
      stripped += line + "\n";
      continue;
    }
    ++marks;
    if (first.empty()) first = line;
    last = line;
    const std::size_t r = line.find(" R");
    const int p = std::stoi(line.substr(5)), m = std::stoi(line.substr(r + 2));
    CHECK(p >= percent);
    CHECK(m <= minutes);
    CHECK((p > percent || m < minutes));
    // What is left by the share and by the minutes agree.
    CHECK(std::abs(total * (1 - p / 100.0) / 60 - m) < 1.2);
    percent = p, minutes = m;
  }
  CHECK(stripped == text);
  CHECK(first == "M73 P0 R" + std::to_string(static_cast<int>(std::ceil(total / 60))));
  CHECK(last == "M73 P100 R0");
  CHECK(marks >= 100);
  CHECK(marks <= 120);
  std::istringstream again(with_progress(text));
  CHECK(gcode::estimate(again, {}).predicted_s == Approx(total).epsilon(1e-3));
}

TEST_CASE("without motion there is no progress") { CHECK(with_progress("M104 S0\n") == "M104 S0\n"); }
