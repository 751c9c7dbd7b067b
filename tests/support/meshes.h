#pragma once

#include <string>

#include "engine/mesh/triangle_mesh.h"

/// Shapes whose every criterion is known in closed form. mm; they stand on z = 0.
namespace voidpath::test {

mesh::TriangleMesh cube(double side);
mesh::TriangleMesh box(double x, double y, double z);
/// Prism over a regular polygon with `sides` corners on the circle, axis z.
mesh::TriangleMesh cylinder(double radius, double height, int sides = 64);
/// Open-top box with the given wall and floor.
mesh::TriangleMesh cup(double x, double y, double z, double wall, double floor);
/// A base plate with n square posts on it, `gap` apart along x.
mesh::TriangleMesh comb(int posts, double post, double gap, double post_height, double base_height);
/// A plate on four square legs at its corners.
mesh::TriangleMesh table(double x, double y, double height, double plate, double leg);
/// UV sphere.
mesh::TriangleMesh sphere(double radius, int rings = 32, int segments = 64);
mesh::TriangleMesh moved(mesh::TriangleMesh mesh, double x, double y, double z);
/// Both meshes' triangles, as shells of their own.
mesh::TriangleMesh joined(const mesh::TriangleMesh& a, const mesh::TriangleMesh& b);

/// The folder of shared test material, from $VOIDPATH_SHARED; empty when it is not set.
std::string shared_dir();

}  // namespace voidpath::test
