#include "engine/pipeline/least_overhang.h"

#include "engine/run/parallel_for.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voidpath::pipeline {

namespace {

using geom::Vec3;

constexpr double kSurfaceShare = 0.01;
/// A facet at exactly the limit does not hang over, whatever rounding did to its normal. Sine of an angle.
constexpr double kRounding = 1e-6;

/// Twice the area times the outward normal of each facet.
std::vector<Vec3> facet_vectors(const mesh::TriangleMesh& mesh) {
  std::vector<Vec3> out;
  out.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[t[0]];
    out.push_back((mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a));
  }
  return out;
}

Underside underside(const mesh::TriangleMesh& mesh, const std::vector<Vec3>& facets, const Vec3& up,
                    const UndersideOptions& options, std::vector<double>& heights) {
  heights.resize(mesh.vertices.size());
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < heights.size(); ++i) {
    heights[i] = up.dot(mesh.vertices[i]);
    lowest = std::min(lowest, heights[i]);
  }
  const double touching = lowest + options.contact_depth_mm;
  const double limit = std::sin(options.overhang_deg * M_PI / 180) + kRounding;
  Underside out;
  for (std::size_t i = 0; i < facets.size(); ++i) {
    const double down = -up.dot(facets[i]);
    if (down <= 0) continue;
    const auto& t = mesh.triangles[i];
    if (std::max({heights[t[0]], heights[t[1]], heights[t[2]]}) <= touching)
      out.contact_mm2 += down / 2;
    else if (down > limit * facets[i].norm())
      out.overhang_mm2 += down / 2;
  }
  return out;
}

}  // namespace

std::vector<Underside> undersides(const mesh::TriangleMesh& mesh, const std::vector<Vec3>& directions,
                                  const UndersideOptions& options, const run::Context& ctx) {
  const std::vector<Vec3> facets = facet_vectors(mesh);
  std::vector<Underside> out(directions.size());
  std::vector<std::vector<double>> scratch(std::max(1U, ctx.thread_count()));
  run::parallel_for_workers(ctx, directions.size(), [&](std::size_t i, unsigned worker) {
    out[i] = underside(mesh, facets, directions[i], options, scratch[worker]);
  });
  return out;
}

double unprintability(const Underside& underside, double surface_mm2) {
  const double s = kSurfaceShare * surface_mm2;
  return (underside.overhang_mm2 + s) / (underside.contact_mm2 + s);
}

}  // namespace voidpath::pipeline
