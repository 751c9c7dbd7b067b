#include "engine/orient/critical_heights.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace voidpath::orient {

namespace {

/// Angles are compared by cosine; this much more is let in, for rounding.
constexpr double kCosineNoise = 1e-12;
/// What a product of unit vectors is off by in single precision, and some more.
constexpr double kSingleNoise = 1e-6;

/// Calls visit(i) for each of `exact` within the angle of d or -d. Nearly all are ruled out in single
/// precision.
template <class Visit>
void each_along(const std::vector<Vec3>& exact, const NearColumns& near, const Vec3& d, double least,
                const Visit& visit) {
  const Lanes bound = Lanes{} + static_cast<float>(least - kSingleNoise);
  for (std::size_t i = 0; i < near.padded(); i += NearColumns::kStep) {
    const Lanes cosine = near.dot(i, d);
    if (!any((cosine >= bound) | (-cosine >= bound))) continue;
    const std::size_t end = std::min(i + NearColumns::kStep, exact.size());
    for (std::size_t k = i; k < end; ++k)
      if (std::abs(exact[k].dot(d)) >= least) visit(k);
  }
}

void add_by_normals(const Solid& s, const Vec3& d, const std::vector<double>& h, double tolerance_deg,
                    std::vector<double>& out) {
  const double least = std::cos(tolerance_deg * std::numbers::pi / 180) - kCosineNoise;
  each_along(s.vertex_normals, s.vertex_normals_near, d, least, [&](std::size_t v) { out.push_back(h[v]); });
  each_along(s.triangle_normals, s.triangle_normals_near, d, least, [&](std::size_t t) {
    const auto& [a, b, c] = s.triangles[t];
    out.push_back((h[a] + h[b] + h[c]) / 3);
  });
}

/// Vertices whose link changes sign other than twice (Banchoff 1967). Equal heights are told apart by index.
void add_by_link(const Solid& s, const std::vector<double>& h, std::vector<double>& out) {
  std::vector<std::uint16_t> changes(s.vertices.size(), 0);
  auto above = [&](Index a, Index b) { return h[a] != h[b] ? h[a] > h[b] : a > b; };
  for (const auto& [a, b, c] : s.triangles) {
    const bool ab = above(a, b);
    const bool bc = above(b, c);
    const bool ca = above(c, a);
    // The link's edge opposite a joins b and c: it changes sign when exactly one of them is above a.
    if (ab == ca) ++changes[a];
    if (bc == ab) ++changes[b];
    if (ca == bc) ++changes[c];
  }
  for (std::size_t v = 0; v < changes.size(); ++v)
    if (changes[v] != 2) out.push_back(h[v]);
}

/// Keeps a sorted list's heights that stand more than `step` above the last one kept; the top stays.
void thin(std::vector<double>& sorted, double step) {
  std::size_t kept = 1;
  const double top = sorted.back();
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (sorted[i] - sorted[kept - 1] > step + kHeightNoise) sorted[kept++] = sorted[i];
  sorted.resize(kept);
  // What lies within noise of the top is the top.
  while (sorted.size() > 1 && top - sorted.back() <= kHeightNoise) sorted.pop_back();
  if (top > sorted.back()) sorted.push_back(top);
}

}  // namespace

void find_slabs(const Solid& solid, const Vec3& d, const std::vector<double>& heights, double lowest,
                double highest, const SearchOptions& options, std::vector<Slab>& out) {
  out.clear();
  if (!(highest > lowest)) return;
  std::vector<double> critical{lowest, highest};
  const bool morse = options.critical == CriticalRule::morse;
  if (morse) {
    add_by_link(solid, heights, critical);
  } else {
    add_by_normals(solid, d, heights, options.normal_tolerance_deg, critical);
  }
  std::sort(critical.begin(), critical.end());
  const double step = morse ? 0.0 : options.min_slab_mm;

  const double height = highest - lowest;
  std::vector<double> kept = critical;
  thin(kept, step);
  for (std::size_t i = 0; i + 1 < kept.size(); ++i)
    out.push_back({0.5 * (kept[i] + kept[i + 1]), (kept[i + 1] - kept[i]) / height, 0});

  kept.assign(critical.rbegin(), critical.rend());
  for (double& x : kept) x = -x;
  thin(kept, step);
  for (std::size_t i = 0; i + 1 < kept.size(); ++i)
    out.push_back({-0.5 * (kept[i] + kept[i + 1]), 0, (kept[i + 1] - kept[i]) / height});

  std::stable_sort(out.begin(), out.end(),
                   [](const Slab& a, const Slab& b) { return a.middle_mm < b.middle_mm; });
  // A slice both directions take is cut once.
  std::size_t last = 0;
  for (std::size_t i = 1; i < out.size(); ++i) {
    if (out[i].middle_mm - out[last].middle_mm <= kHeightNoise && out[last].weight_down == 0 &&
        out[i].weight_up == 0) {
      out[last].weight_down = out[i].weight_down;
    } else {
      out[++last] = out[i];
    }
  }
  out.resize(last + 1);
}

}  // namespace voidpath::orient
