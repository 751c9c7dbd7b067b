#include "engine/report/void_columns.h"

#include "engine/report/scan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace voidpath::report {

namespace {

/// Columns along the longer side: finer than a picture of the part shows.
constexpr double kColumns = 220;
/// What lies this near to the plate rests on it. mm
constexpr double kOnPlate_mm = 0.2;
/// Gaps thinner than this are the noise of a surface that folds back on itself. mm
constexpr float kThinnest_mm = 1e-3F;

/// An overhang narrower than this, two beads, is held by what is beside it. mm
constexpr double kLip_mm = 0.8;

struct Crossing {
  float z;
  bool enters;  ///< material above it
  bool overhang;
};

}  // namespace

std::vector<bool> find_overhangs(const mesh::TriangleMesh& standing, double overhang_deg) {
  // A hair of tolerance: faces at exactly the limit need none.
  const double limit = -std::sin(overhang_deg * std::numbers::pi / 180) - 1e-6;
  std::vector<bool> out(standing.triangles.size(), false);
  for (std::size_t t = 0; t < out.size(); ++t) {
    const auto& [a, b, c] = standing.triangles[t];
    const geom::Vec3& p = standing.vertices[a];
    const geom::Vec3& q = standing.vertices[b];
    const geom::Vec3& r = standing.vertices[c];
    const geom::Vec3 n = (q - p).cross(r - p);
    const double length = n.norm();
    out[t] = length > 0 && n.z() < limit * length && std::max({p.z(), q.z(), r.z()}) > kOnPlate_mm;
  }
  return out;
}

VoidColumns::VoidColumns(const mesh::TriangleMesh& standing, double overhang_deg) {
  const mesh::Bounds box = mesh::bounds(standing);
  const double longest = std::max(box.size().x(), box.size().y());
  if (!(longest > 0)) {
    begin_ = {0};
    return;
  }
  cell_ = longest / kColumns;
  x0_ = box.min.x();
  y0_ = box.min.y();
  width_ = std::max(1, static_cast<int>(std::ceil(box.size().x() / cell_)));
  depth_ = std::max(1, static_cast<int>(std::ceil(box.size().y() / cell_)));

  const std::vector<bool> overhang = find_overhangs(standing, overhang_deg);
  const auto each_crossing = [&](auto&& at) {
    for (std::size_t t = 0; t < standing.triangles.size(); ++t) {
      std::array<Corner, 3> c;
      for (std::size_t k = 0; k < 3; ++k) {
        const geom::Vec3& v = standing.vertices[standing.triangles[t][k]];
        c[k] = {(v.x() - x0_) / cell_, (v.y() - y0_) / cell_, v.z()};
      }
      const double twice = (c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (c[1].y - c[0].y);
      scan(c, width_, depth_, [&](int i, int j, double z) {
        at(index(i, j), Crossing{static_cast<float>(z), twice < 0, overhang[t]});
      });
    }
  };
  const std::size_t columns = index(width_ - 1, depth_ - 1) + 1;
  std::vector<std::size_t> start(columns + 1, 0);
  each_crossing([&](std::size_t column, const Crossing&) { ++start[column + 1]; });
  for (std::size_t i = 0; i < columns; ++i) start[i + 1] += start[i];
  std::vector<Crossing> crossings(start.back());
  std::vector<std::size_t> next(start.begin(), start.end() - 1);
  each_crossing([&](std::size_t column, const Crossing& c) { crossings[next[column]++] = c; });

  begin_.reserve(columns + 1);
  for (std::size_t i = 0; i < columns; ++i) {
    begin_.push_back(gaps_.size());
    const auto first = crossings.begin() + static_cast<std::ptrdiff_t>(start[i]);
    const auto last = crossings.begin() + static_cast<std::ptrdiff_t>(start[i + 1]);
    // At one height: out before in, so that stacked bodies leave no gap.
    std::stable_sort(first, last, [](const Crossing& a, const Crossing& b) {
      return a.z != b.z ? a.z < b.z : !a.enters && b.enters;
    });
    int inside = 0;
    float floor = 0;
    for (auto c = first; c != last; ++c) {
      if (c->enters && inside++ == 0 && c->z - floor > kThinnest_mm)
        gaps_.push_back({floor, c->z, c->overhang});
      if (!c->enters && --inside == 0) floor = c->z;
    }
  }
  begin_.push_back(gaps_.size());
  drop_lips();
}

/// Columns within reach that have a gap beside this one that passes the test.
template <class Test>
int VoidColumns::count_around(int i, int j, const Gap& gap, int reach, Test&& test) const {
  int out = 0;
  for (int dj = -reach; dj <= reach; ++dj)
    for (int di = -reach; di <= reach; ++di) {
      const Range beside = gaps(i + di, j + dj);
      out += std::any_of(beside.begin(), beside.end(),
                         [&](const Gap& g) { return g.bottom < gap.top && gap.bottom < g.top && test(g); });
    }
  return out;
}

/// Opens the overhangs (erosion, then dilation, by half of kLip_mm).
void VoidColumns::drop_lips() {
  const int reach = static_cast<int>(std::lround(0.5 * kLip_mm / cell_));
  if (reach == 0) return;
  const int window = (2 * reach + 1) * (2 * reach + 1);
  std::vector<std::uint8_t> core(gaps_.size(), 0);
  std::vector<std::uint8_t> kept(gaps_.size(), 0);
  const auto number = [&](const Gap& g) { return static_cast<std::size_t>(&g - gaps_.data()); };
  const auto each_overhang = [&](auto&& at) {
    for (int j = 0; j < depth_; ++j)
      for (int i = 0; i < width_; ++i)
        for (const Gap& g : gaps(i, j))
          if (g.overhang) at(i, j, g);
  };
  each_overhang([&](int i, int j, const Gap& g) {
    core[number(g)] = count_around(i, j, g, reach, [](const Gap& o) { return o.overhang; }) == window;
  });
  each_overhang([&](int i, int j, const Gap& g) {
    kept[number(g)] = count_around(i, j, g, reach, [&](const Gap& o) { return core[number(o)] != 0; }) > 0;
  });
  for (std::size_t i = 0; i < gaps_.size(); ++i) gaps_[i].overhang = kept[i] != 0;
}

VoidColumns::Range VoidColumns::gaps(int i, int j) const {
  if (i < 0 || j < 0 || i >= width_ || j >= depth_) return {nullptr, nullptr};
  const std::size_t k = index(i, j);
  return {gaps_.data() + begin_[k], gaps_.data() + begin_[k + 1]};
}

double VoidColumns::support_mm3() const {
  double sum = 0;
  for (const Gap& g : gaps_)
    if (g.overhang) sum += static_cast<double>(g.top) - static_cast<double>(g.bottom);
  return sum * cell_ * cell_;
}

std::vector<double> VoidColumns::area_by_height(double height_mm, std::size_t count) const {
  std::vector<double> out(count, 0.0);
  if (!(height_mm > 0) || count == 0) return out;
  const double layer = height_mm / static_cast<double>(count);
  for (const Gap& g : gaps_) {
    const double from = std::clamp(static_cast<double>(g.bottom) / layer, 0.0, static_cast<double>(count));
    const double to = std::clamp(static_cast<double>(g.top) / layer, 0.0, static_cast<double>(count));
    for (auto k = static_cast<std::size_t>(from); k < count && static_cast<double>(k) < to; ++k) {
      const double share = std::min(to, static_cast<double>(k + 1)) - std::max(from, static_cast<double>(k));
      out[k] += share * cell_ * cell_;
    }
  }
  return out;
}

}  // namespace voidpath::report
