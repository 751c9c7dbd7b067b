#include "engine/mesh/triangle_mesh.h"

#include <cmath>

namespace voidpath::mesh {

namespace {

/// Areas and volumes are summed about a point of the mesh, so that a part far from the origin loses nothing.
Vec3 anchor(const TriangleMesh& mesh) {
  return mesh.vertices.empty() ? Vec3::Zero() : Vec3(0.5 * (bounds(mesh).min + bounds(mesh).max));
}

}  // namespace

Bounds bounds(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return {};
  Bounds b{mesh.vertices.front(), mesh.vertices.front()};
  for (const Vec3& v : mesh.vertices) {
    b.min = b.min.cwiseMin(v);
    b.max = b.max.cwiseMax(v);
  }
  return b;
}

double volume(const TriangleMesh& mesh) {
  const Vec3 o = anchor(mesh);
  double six = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - o;
    const Vec3 b = mesh.vertices[t[1]] - o;
    const Vec3 c = mesh.vertices[t[2]] - o;
    six += a.dot(b.cross(c));
  }
  return six / 6;
}

double surface_area(const TriangleMesh& mesh) {
  double two = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[t[0]];
    two += (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm();
  }
  return two / 2;
}

Vec3 centroid(const TriangleMesh& mesh) {
  const Vec3 o = anchor(mesh);
  double six = 0;
  Vec3 sum = Vec3::Zero();
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - o;
    const Vec3 b = mesh.vertices[t[1]] - o;
    const Vec3 c = mesh.vertices[t[2]] - o;
    const double v = a.dot(b.cross(c));
    six += v;
    sum += v * (a + b + c);
  }
  const double box = bounds(mesh).size().prod();
  if (std::abs(six) <= 1e-12 * box || six == 0) return o;
  return o + sum / (4 * six);
}

geom::Quaternion rotation_to_up(const Vec3& direction) {
  const Vec3 d = direction.normalized();
  // Just above the opposite pole the shortest turn is ill-defined; there and at it, half a turn about x.
  if (d.z() < -1 + 1e-12) return geom::Quaternion(0, 1, 0, 0);
  return geom::Quaternion::FromTwoVectors(d, Vec3::UnitZ()).normalized();
}

TriangleMesh rotated(const TriangleMesh& mesh, const geom::Quaternion& q) {
  const geom::Mat3 r = q.normalized().toRotationMatrix();
  TriangleMesh out{mesh.vertices, mesh.triangles};
  for (Vec3& v : out.vertices) v = r * v;
  return out;
}

TriangleMesh turned(const TriangleMesh& mesh, const Vec3& direction) {
  TriangleMesh out = rotated(mesh, rotation_to_up(direction));
  const Bounds b = bounds(out);
  const Vec3 shift(-0.5 * (b.min.x() + b.max.x()), -0.5 * (b.min.y() + b.max.y()), -b.min.z());
  for (Vec3& v : out.vertices) v += shift;
  return out;
}

}  // namespace voidpath::mesh
