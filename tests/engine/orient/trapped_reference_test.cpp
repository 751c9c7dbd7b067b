#include "tests/engine/orient/trapped_reference.h"

#include "tests/support/meshes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

namespace voidpath::test {

namespace {

using geom::Vec3;

/// Where a line goes through a facet.
struct Hit {
  float z;
  int up;  ///< 1: a facet that looks up, -1: one that looks down
};

class Lines {
 public:
  Lines(const mesh::TriangleMesh& mesh, const Vec3& d, double turn, int lines)
      : mesh_(mesh), n_(static_cast<std::size_t>(lines)), random_(static_cast<unsigned>(1 + lines)) {
    const Vec3 u = d.normalized().unitOrthogonal();
    const Vec3 v = d.normalized().cross(u);
    const Vec3 e1 = std::cos(turn) * u + std::sin(turn) * v;
    const Vec3 e2 = d.normalized().cross(e1);
    for (const Vec3& p : mesh.vertices) seen_.emplace_back(e1.dot(p), e2.dot(p), d.normalized().dot(p));
    low_ = high_ = seen_.front();
    for (const Vec3& p : seen_) {
      low_ = low_.cwiseMin(p);
      high_ = high_.cwiseMax(p);
    }
    pitch_ = (high_ - low_) / static_cast<double>(n_);
  }

  TrappedReference measure() {
    using Row = std::vector<std::uint32_t>;
    std::vector<Row> starts(n_);
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      starts[row_of(lowest(t))].push_back(static_cast<std::uint32_t>(t));
    TrappedReference sum;
    Row active;
    std::vector<std::vector<Hit>> hits(n_);
    for (std::size_t j = 0; j < n_; ++j) {
      active.insert(active.end(), starts[j].begin(), starts[j].end());
      std::erase_if(active, [&](std::uint32_t t) { return row_of(highest(t)) < j; });
      const double y = low_.y() + (static_cast<double>(j) + anywhere_(random_)) * pitch_.y();
      const double x0 = low_.x() + anywhere_(random_) * pitch_.x();
      for (const std::uint32_t t : active) cut(t, y, x0, hits);
      for (auto& line : hits) add(line, sum);
    }
    sum.up_mm3 *= pitch_.x() * pitch_.y();
    sum.down_mm3 *= pitch_.x() * pitch_.y();
    return sum;
  }

 private:
  const Vec3& corner(std::size_t t, std::size_t k) const { return seen_[mesh_.triangles[t][k % 3]]; }
  double lowest(std::size_t t) const {
    return std::min({corner(t, 0).y(), corner(t, 1).y(), corner(t, 2).y()});
  }
  double highest(std::size_t t) const {
    return std::max({corner(t, 0).y(), corner(t, 1).y(), corner(t, 2).y()});
  }
  std::size_t row_of(double y) const {
    const double row = std::floor((y - low_.y()) / pitch_.y());
    return static_cast<std::size_t>(std::clamp(row, 0.0, static_cast<double>(n_ - 1)));
  }

  void cut(std::size_t t, double y, double x0, std::vector<std::vector<Hit>>& hits) {
    double x[2] = {0, 0};
    double z[2] = {0, 0};
    std::size_t found = 0;
    for (std::size_t k = 0; k < 3 && found < 2; ++k) {
      // From the lower end, so that both facets of an edge find the same point on it.
      const Vec3* a = &corner(t, k);
      const Vec3* b = &corner(t, k + 1);
      if ((a->y() < y) == (b->y() < y)) continue;
      if (b->y() < a->y()) std::swap(a, b);
      const double r = (y - a->y()) / (b->y() - a->y());
      x[found] = a->x() + r * (b->x() - a->x());
      z[found++] = a->z() + r * (b->z() - a->z());
    }
    if (found < 2) return;
    const Vec3 p = corner(t, 1) - corner(t, 0);
    const Vec3 q = corner(t, 2) - corner(t, 0);
    const int up = p.x() * q.y() - p.y() * q.x() > 0 ? 1 : -1;
    if (x[1] < x[0]) {
      std::swap(x[0], x[1]);
      std::swap(z[0], z[1]);
    }
    const double last = std::min(std::ceil((x[1] - x0) / pitch_.x()), static_cast<double>(n_));
    for (double i = std::max(0.0, std::ceil((x[0] - x0) / pitch_.x())); i < last; ++i) {
      const double r = (x0 + i * pitch_.x() - x[0]) / (x[1] - x[0]);
      hits[static_cast<std::size_t>(i)].push_back({static_cast<float>(z[0] + r * (z[1] - z[0])), up});
    }
  }

  /// Heights of the gaps of one line, which is then empty.
  void add(std::vector<Hit>& line, TrappedReference& sum) {
    if (line.empty()) return;
    std::sort(line.begin(), line.end(), [](const Hit& a, const Hit& b) { return a.z < b.z; });
    double gaps = 0;
    double below = line.front().z;
    int winding = 0;
    for (const Hit& h : line) {
      if (winding == 0) gaps += h.z - below;
      winding -= h.up;
      below = h.z;
    }
    sum.up_mm3 += gaps + line.front().z - low_.z();
    sum.down_mm3 += gaps + high_.z() - line.back().z;
    line.clear();
  }

  const mesh::TriangleMesh& mesh_;
  std::size_t n_;
  std::vector<Vec3> seen_;
  Vec3 low_, high_, pitch_;
  std::minstd_rand random_;
  std::uniform_real_distribution<double> anywhere_{0, 1};
};

}  // namespace

TrappedReference trapped_reference(const mesh::TriangleMesh& mesh, const Vec3& d, int lines) {
  const TrappedReference a = Lines(mesh, d, 0.41, lines).measure();
  const TrappedReference b = Lines(mesh, d, 1.33, lines + 1).measure();
  return {(a.up_mm3 + b.up_mm3) / 2, (a.down_mm3 + b.down_mm3) / 2,
          std::max(std::abs(a.up_mm3 - b.up_mm3), std::abs(a.down_mm3 - b.down_mm3))};
}

TEST_CASE("the dense reference gives the closed forms of a table and a tilted cube") {
  const TrappedReference t = trapped_reference(table(40, 30, 20, 4, 5), Vec3::UnitZ(), 400);
  CHECK(t.up_mm3 == Approx((40 * 30 - 4 * 25) * 16.0).epsilon(0.002));
  CHECK(t.down_mm3 == Approx(0).margin(0.1));
  // On an edge: 2 wedges of a right-angled triangle with legs a/√2 beneath it. On a corner: 3/2 of the cube.
  const double a = 20;
  const TrappedReference edge = trapped_reference(cube(a), Vec3(1, 1, 0), 400);
  CHECK(edge.up_mm3 == Approx(a * a * a / 2).epsilon(0.002));
  CHECK(edge.down_mm3 == Approx(a * a * a / 2).epsilon(0.002));
  // Under the lower faces: the cube's shadow, √3 a², times the mean height of three faces whose corners are
  // at 0, 1, 1 and 2 thirds of √3 a.
  const TrappedReference corner = trapped_reference(cube(a), Vec3(1, 1, 1), 400);
  CHECK(corner.up_mm3 == Approx(a * a * a).epsilon(0.002));
}

}  // namespace voidpath::test
