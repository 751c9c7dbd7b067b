#pragma once

#include "engine/orient/search.h"

#include <vector>

/// The directions a search looks at.
namespace voidpath::orient {

/// Triangles of an icosphere, `subdivisions` times split in four, projected centroids (§3.2.1): 20·4^n unit
/// vectors. They come in pairs, d before -d, and -d is the exact negative.
std::vector<Vec3> icosphere_directions(int subdivisions);

/// ±x, ±y, ±z, in pairs too, +z first of its pair.
std::vector<Vec3> axis_directions();

/// The one of d and -d that stands for both: first nonzero of z, y, x positive.
bool is_canonical(const Vec3& d);

/// What a part can lie on: build directions that put a face of its convex hull on the plate.
struct RestingFace {
  Vec3 direction;  ///< up, when the part lies on the face
  double area_mm2 = 0;
};

/// Hull faces whose normals differ by less than this are one face, rad. Far below what a print shows, far
/// above the noise of single-precision files.
inline constexpr double kCoplanarAngle = 2e-3;
/// More than these never get a say: the largest come first, and a hull with more faces is a round body,
/// which the sampled directions cover.
inline constexpr std::size_t kMaxRestingFaces = 200;

/// Faces of the convex hull, coplanar ones merged, largest first, at most `limit`.
std::vector<RestingFace> resting_faces(const std::vector<Vec3>& points, std::size_t limit = kMaxRestingFaces);

}  // namespace voidpath::orient
