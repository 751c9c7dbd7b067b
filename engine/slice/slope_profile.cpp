#include "engine/slice/slope_profile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace voidpath::slice {

namespace {

/// Faces whose normal leans less than this from the horizontal have no steps worth counting.
constexpr double kUpright = 1e-6;

/// Faces whose normal leans less than about 1° from the vertical are level.
constexpr double kLevel = 0.9998;

/// Share of a triangle below z, for the heights of its corners in order.
double share_below(double z, const std::array<double, 3>& h) {
  if (z <= h[0]) return 0;
  if (z >= h[2]) return 1;
  if (z < h[1]) return (z - h[0]) * (z - h[0]) / ((h[1] - h[0]) * (h[2] - h[0]));
  return 1 - (h[2] - z) * (h[2] - z) / ((h[2] - h[1]) * (h[2] - h[0]));
}

}  // namespace

SlopeProfile::Sums& SlopeProfile::Sums::operator+=(const Sums& other) {
  area += other.area;
  area_z += other.area_z;
  normal_area += other.normal_area;
  normal_area_z += other.normal_area_z;
  level_area += other.level_area;
  level_area_z += other.level_area_z;
  up_area += other.up_area;
  up_area_z += other.up_area_z;
  return *this;
}

SlopeProfile::SlopeProfile(const mesh::TriangleMesh& mesh, double from_mm, double step_mm, std::size_t count)
    : from_(from_mm), step_(step_mm), below_(count + 2) {
  for (const auto& t : mesh.triangles) add(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
  Sums sum;
  for (Sums& s : below_) {
    const Sums here = std::exchange(s, sum);
    sum += here;
  }
}

void SlopeProfile::put(double z, double area, double slope) {
  const double at = (z - from_) / step_;
  if (at < 0 || at >= static_cast<double>(below_.size() - 1)) return;
  Sums& s = below_[static_cast<std::size_t>(at)];
  if (std::abs(slope) >= kLevel) {
    s.level_area += area;
    s.level_area_z += area * z;
  } else {
    s.area += area;
    s.area_z += area * z;
    s.normal_area += area * std::abs(slope);
    s.normal_area_z += area * std::abs(slope) * z;
  }
  s.up_area += std::copysign(area, slope);
  s.up_area_z += std::copysign(area, slope) * z;
}

void SlopeProfile::add(const mesh::Vec3& a, const mesh::Vec3& b, const mesh::Vec3& c) {
  const mesh::Vec3 normal = (b - a).cross(c - a);
  const double size = normal.norm();
  if (!(size > 0) || std::abs(normal.z()) < kUpright * size) return;
  const double area = 0.5 * std::abs(normal.z());
  const double slope = normal.z() / size;
  std::array<double, 3> h{a.z(), b.z(), c.z()};
  std::sort(h.begin(), h.end());
  if (h[2] - h[0] <= step_) return put((h[0] + h[1] + h[2]) / 3, area, slope);
  const double top = z_of(below_.size() - 1);
  const double begin = std::max(h[0], from_);
  double share = share_below(begin, h);
  for (auto i = static_cast<std::size_t>((begin - from_) / step_); i + 1 < below_.size(); ++i) {
    const double low = std::max(z_of(i), begin);
    if (low >= std::min(h[2], top)) break;
    const double high = std::min(z_of(i + 1), h[2]);
    const double next = share_below(high, h);
    if (next > share) put(0.5 * (low + high), area * (next - share), slope);
    share = next;
  }
}

SlopeProfile::Misfit SlopeProfile::misfit(std::size_t a, std::size_t b) const {
  const std::size_t m = a + (b - a) / 2;
  const Sums &sa = below_[a], &sm = below_[m], &sb = below_[b];
  const double za = z_of(a);
  const double zb = z_of(b);
  // The lower half counts by its distance from the layer's bottom, the upper one from its top.
  auto missed = [&](double Sums::*area, double Sums::*area_z) {
    return (sm.*area_z - sa.*area_z) - za * (sm.*area - sa.*area) + zb * (sb.*area - sm.*area) -
           (sb.*area_z - sm.*area_z);
  };
  Misfit out;
  out.slope_mm2 = sb.area - sa.area;
  out.slope_mm3 = missed(&Sums::normal_area, &Sums::normal_area_z);
  out.level_mm2 = sb.level_area - sa.level_area;
  out.level_mm3 = missed(&Sums::level_area, &Sums::level_area_z);
  out.volume_mm3 = missed(&Sums::area, &Sums::area_z) + out.level_mm3;
  return out;
}

double SlopeProfile::volume_above_mm3(std::size_t a) const {
  const Sums& all = below_.back();
  const Sums& s = below_[a];
  return (all.up_area_z - s.up_area_z) - z_of(a) * (all.up_area - s.up_area);
}

}  // namespace voidpath::slice
