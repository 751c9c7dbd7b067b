#include "tests/fidelity/modes.h"
#include "tests/fidelity/shapes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <sstream>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::fidelity;

namespace {

constexpr double kPi = std::numbers::pi;
/// Filament of this diameter has a cross-section of 1 mm².
const double kUnitDiameter = std::sqrt(4 / kPi);

Print read_text(const std::string& text) {
  std::istringstream in(text);
  return read_print(in, kUnitDiameter, 1);
}

double length_of(const Layer& layer) {
  double sum = 0;
  for (const Bead& b : layer.beads) sum += std::hypot(b.x1 - b.x0, b.y1 - b.y0);
  return sum;
}

const std::string kHead = "M83\n;LAYER_CHANGE\n;Z:0.2\n;HEIGHT:0.2\n;TYPE:Perimeter\n;WIDTH:0.45\nG1 Z0.2\n";

/// Cells of segments, to find the nearest.
class Segments {
 public:
  explicit Segments(const Layer& layer) {
    for (const Bead& b : layer.beads) {
      const double length = std::hypot(b.x1 - b.x0, b.y1 - b.y0);
      const int n = static_cast<int>(length / kCell) + 1;
      for (int k = 0; k <= n; ++k) {
        const double t = static_cast<double>(k) / n;
        auto& cell = cells_[key(b.x0 + t * (b.x1 - b.x0), b.y0 + t * (b.y1 - b.y0))];
        if (cell.empty() || cell.back() != &b) cell.push_back(&b);
      }
    }
  }

  double distance(double x, double y) const {
    double best = kCell;
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j) {
        const auto cell = cells_.find(key(x + i * kCell, y + j * kCell));
        if (cell == cells_.end()) continue;
        for (const Bead* b : cell->second) best = std::min(best, to(*b, x, y));
      }
    return best;
  }

 private:
  static constexpr double kCell = 0.5;  ///< mm
  static std::pair<long, long> key(double x, double y) {
    return {std::lround(std::floor(x / kCell)), std::lround(std::floor(y / kCell))};
  }
  static double to(const Bead& b, double x, double y) {
    const double dx = b.x1 - b.x0, dy = b.y1 - b.y0;
    const double t =
        std::clamp(((x - b.x0) * dx + (y - b.y0) * dy) / std::max(dx * dx + dy * dy, 1e-12), 0.0, 1.0);
    return std::hypot(x - b.x0 - t * dx, y - b.y0 - t * dy);
  }
  std::map<std::pair<long, long>, std::vector<const Bead*>> cells_;
};

/// How far the strands of one print stray from those of the other, mm.
double strays(const Print& from, const Print& other) {
  double worst = 0;
  for (std::size_t i = 0; i < from.layers.size(); ++i) {
    const Segments segments(other.layers[i]);
    for (const Bead& b : from.layers[i].beads)
      for (const double t : {0.0, 0.5, 1.0})
        worst = std::max(worst, segments.distance(b.x0 + t * (b.x1 - b.x0), b.y0 + t * (b.y1 - b.y0)));
  }
  return worst;
}

}  // namespace

TEST_CASE("arcs are read as what they are") {
  // A quarter to the left of radius 10 around (0, 0), and its material: a cross-section of 0.08 mm².
  const double quarter = kPi / 2 * 10;
  const Print left = read_text(kHead + "G1 X10 Y0\nG3 X0 Y10 I-10 J0 E" + std::to_string(0.08 * quarter));
  REQUIRE(left.complaints.empty());
  const Layer& l = left.layers.front();
  CHECK(length_of(l) == Approx(quarter).epsilon(1e-4));
  CHECK(l.volume == Approx(0.08 * quarter).epsilon(1e-5));
  for (const Bead& b : l.beads) {
    CHECK(std::hypot(b.x1, b.y1) == Approx(10).margin(1e-9));
    CHECK(b.x1 >= -1e-9);
    CHECK(b.y1 >= -1e-9);
    CHECK(b.width == Approx(0.08 / 0.2 + 0.2 * (1 - kPi / 4)).epsilon(1e-3));
  }
  // The same ends to the right go the long way round.
  const Print right = read_text(kHead + "G1 X10 Y0\nG2 X0 Y10 I-10 J0 E1");
  CHECK(length_of(right.layers.front()) == Approx(3 * quarter).epsilon(1e-4));
  // Back to where it began is a full turn.
  const Print whole = read_text(kHead + "G1 X10 Y0\nG2 I-10 J0 E1");
  CHECK(length_of(whole.layers.front()) == Approx(4 * quarter).epsilon(1e-4));
  // Between two radii, or around nothing, it is a mistake.
  CHECK(read_text(kHead + "G1 X10 Y0\nG3 X0 Y11 I-10 J0 E1").complaints.size() == 1);
  CHECK(read_text(kHead + "G1 X10 Y0\nG3 X0 Y10 E1").complaints.size() == 1);
}

TEST_CASE("a bead's width is told by its own height") {
  const double area = (0.5 - 0.4 * (1 - kPi / 4)) * 0.4;  // 0.5 wide, 0.4 high
  const Print print =
      read_text(kHead + ";HEIGHT:0.4\n;WIDTH:0.5\nG1 X0 Y0\nG1 X10 E" + std::to_string(10 * area));
  const Layer& l = print.layers.front();
  REQUIRE(l.beads.size() == 1);
  CHECK(l.height == Approx(0.2));
  CHECK(l.beads[0].width == Approx(0.5).epsilon(1e-4));
  CHECK(l.volume == Approx(l.implied).epsilon(1e-4));
  // As high as wide: a strand in the air.
  const Print strand =
      read_text(kHead + ";HEIGHT:0.4\n;WIDTH:0.4\nG1 X0 Y0\nG1 X10 E" + std::to_string(10 * kPi * 0.04));
  CHECK(strand.layers.front().beads.at(0).round);
  CHECK(strand.layers.front().beads.at(0).width == Approx(0.4).epsilon(1e-4));
}

TEST_CASE("paths with arcs keep to those without") {
  for (const auto& mesh : {beaker(), ball(), drilled()}) {
    auto options = options_for({});
    const Print straight = read(sliced(mesh, options));
    options.print.machine.arcs = true;
    const Sliced fitted = sliced(mesh, options);
    CHECK(std::count(fitted.gcode.begin(), fitted.gcode.end(), 'J') > 20);
    const Print curved = read(fitted);
    REQUIRE(curved.complaints.empty());
    REQUIRE(curved.layers.size() == straight.layers.size());
    // The pieces an arc is read in lie within 0.001 mm of it, and so do the digits of its centre.
    const double tolerance = options.print.slice.arc_tolerance_mm + 0.002;
    CHECK(strays(curved, straight) <= tolerance);
    CHECK(strays(straight, curved) <= tolerance);
    for (std::size_t i = 0; i < straight.layers.size(); ++i)
      CHECK(curved.layers[i].volume == Approx(straight.layers[i].volume).epsilon(1e-4));
  }
}
