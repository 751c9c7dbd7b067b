#include "engine/mesh/triangulate.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

namespace voidpath::mesh {

namespace {

using Vec2 = Eigen::Vector2d;

/// A corner turning by less than this share of the ring's area counts as straight: rounding of decimals.
constexpr double kFlatShare = 1e-12;
/// Tests spent per corner before corners are clipped without looking: keeps hostile rings from hanging.
constexpr std::size_t kTestsPerCorner = 1000;

double cross(const Vec2& o, const Vec2& a, const Vec2& b) {
  return (a - o).x() * (b - o).y() - (a - o).y() * (b - o).x();
}

class EarClipper {
 public:
  EarClipper(std::vector<Vec2> points, double flat) : p_(std::move(points)), flat_(flat) {
    const auto n = static_cast<std::uint32_t>(p_.size());
    next_.resize(n);
    prev_.resize(n);
    for (std::uint32_t i = 0; i < n; ++i) {
      next_[i] = i + 1 == n ? 0 : i + 1;
      prev_[i] = i == 0 ? n - 1 : i - 1;
    }
    budget_ = 4 * p_.size() * std::min(p_.size(), kTestsPerCorner) + 64;
  }

  bool run(std::vector<Triangle>& out) {
    bool clean = true;
    std::uint32_t at = 0;
    std::size_t left = p_.size(), since_ear = 0;
    while (left > 3) {
      const bool ear = is_ear(at);
      if (!ear && since_ear < left && budget_ > 0) {
        at = next_[at];
        ++since_ear;
        continue;
      }
      if (!ear) clean = false;
      out.push_back({prev_[at], at, next_[at]});
      next_[prev_[at]] = next_[at];
      prev_[next_[at]] = prev_[at];
      // Going on beyond the neighbour alternates sides and so avoids needles.
      at = next_[next_[at]];
      since_ear = 0;
      --left;
    }
    out.push_back({prev_[at], at, next_[at]});
    return clean;
  }

 private:
  bool is_ear(std::uint32_t i) {
    const Vec2 &a = p_[prev_[i]], &b = p_[i], &c = p_[next_[i]];
    if (cross(a, b, c) <= flat_) return false;
    for (std::uint32_t k = next_[next_[i]]; k != prev_[i]; k = next_[k]) {
      if (budget_ == 0) return false;
      --budget_;
      const Vec2& q = p_[k];
      if (q == a || q == b || q == c) continue;
      if (cross(a, b, q) >= 0 && cross(b, c, q) >= 0 && cross(c, a, q) >= 0) return false;
    }
    return true;
  }

  std::vector<Vec2> p_;
  std::vector<std::uint32_t> next_, prev_;
  double flat_;
  std::size_t budget_ = 0;
};

}  // namespace

Vec3 ring_vector_area(std::span<const Vec3> ring) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
    sum += (ring[i] - ring[0]).cross(ring[i + 1] - ring[0]);
  }
  return sum;
}

bool triangulate(std::span<const Vec3> ring, std::vector<Triangle>& out) {
  if (ring.size() == 3) {
    out.push_back({0, 1, 2});
    return true;
  }
  const Vec3 area = ring_vector_area(ring);
  const double twice = area.norm();
  Vec3 u = Vec3::UnitX(), v = Vec3::UnitY();
  if (twice > 0) {
    const Vec3 n = area / twice;
    u = n.unitOrthogonal();
    v = n.cross(u);
  }
  std::vector<Vec2> flat;
  flat.reserve(ring.size());
  for (const Vec3& p : ring) flat.emplace_back((p - ring[0]).dot(u), (p - ring[0]).dot(v));
  return EarClipper(std::move(flat), kFlatShare * twice).run(out) && twice > 0;
}

void triangulate_least_area(std::span<const Vec3> ring, std::vector<Triangle>& out) {
  const auto n = static_cast<std::uint32_t>(ring.size());
  const auto at = [n](std::uint32_t i, std::uint32_t j) { return std::size_t{i} * n + j; };
  // least[i, j]: twice the least area over the points i..j, closed by the chord; via[i, j]: the third corner
  // of the facet on that chord.
  std::vector<double> least(std::size_t{n} * n, 0);
  std::vector<std::uint32_t> via(std::size_t{n} * n, 0);
  for (std::uint32_t span = 2; span < n; ++span) {
    for (std::uint32_t i = 0; i + span < n; ++i) {
      const std::uint32_t j = i + span;
      double best = std::numeric_limits<double>::infinity();
      for (std::uint32_t k = i + 1; k < j; ++k) {
        const double area = (ring[k] - ring[i]).cross(ring[j] - ring[i]).norm();
        const double sum = least[at(i, k)] + least[at(k, j)] + area;
        if (sum >= best) continue;
        best = sum;
        via[at(i, j)] = k;
      }
      least[at(i, j)] = best;
    }
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> chords = {{0, n - 1}};
  while (!chords.empty()) {
    const auto [i, j] = chords.back();
    chords.pop_back();
    if (j - i < 2) continue;
    const std::uint32_t k = via[at(i, j)];
    out.push_back({i, k, j});
    chords.emplace_back(i, k);
    chords.emplace_back(k, j);
  }
}

}  // namespace voidpath::mesh
