#pragma once

#include "engine/mesh/triangle_mesh.h"

#include <cstddef>
#include <vector>

namespace voidpath::slice {

/// How the surface of a mesh leans, by height, on a lattice of z: enough to tell in constant time what a
/// layer with upright sides, cut at its middle, misses of the part or adds to it.
///
/// A vertical line that meets the surface at z inside a layer [a, b] is solid on one side of z alone; the
/// layer has it solid throughout, if its middle is, or not at all. What differs is min(z - a, b - z) of its
/// length. Summed over the lines, by the surface's projection onto the plate, this is a volume.
class SlopeProfile {
 public:
  /// Points of the lattice are from_mm + i × step_mm, i up to `count`; what lies outside is left out.
  SlopeProfile(const mesh::TriangleMesh& mesh, double from_mm, double step_mm, std::size_t count);

  /// Of the layer between two points of the lattice that are an even number apart.
  struct Misfit {
    double volume_mm3 = 0;  ///< between the surface and the layer's steps
    double slope_mm2 = 0;   ///< surface that leans, in the layer, as seen from above or below
    double slope_mm3 = 0;   ///< its share of the volume, with distances along its normal
    double level_mm2 = 0;   ///< horizontal faces in the layer
    double level_mm3 = 0;   ///< their share of the volume
  };
  Misfit misfit(std::size_t a, std::size_t b) const;
  /// Volume of the part above a point of the lattice: what a print that ends there lacks.
  double volume_above_mm3(std::size_t a) const;

 private:
  /// Sums over the surface below a point of the lattice.
  struct Sums {
    double area = 0;         ///< projected, of what leans
    double area_z = 0;       ///< × z
    double normal_area = 0;  ///< × the normal's share of z
    double normal_area_z = 0;
    double level_area = 0;
    double level_area_z = 0;
    double up_area = 0;  ///< of everything; faces that look down counted negative
    double up_area_z = 0;
    Sums& operator+=(const Sums& other);
  };
  void add(const mesh::Vec3& a, const mesh::Vec3& b, const mesh::Vec3& c);
  void put(double z, double area, double slope);  ///< slope: the normal's z, with its sign
  double z_of(std::size_t i) const { return from_ + static_cast<double>(i) * step_; }

  double from_;
  double step_;
  std::vector<Sums> below_;  ///< until the constructor ends: by interval above the point
};

}  // namespace voidpath::slice
