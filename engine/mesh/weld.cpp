#include "engine/mesh/weld.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace voidpath::mesh {

namespace {

constexpr std::uint32_t kFree = std::numeric_limits<std::uint32_t>::max();

std::uint64_t mix(std::uint64_t h) {
  h ^= h >> 32;
  h *= 0xd6e8feb86659fd93ULL;
  h ^= h >> 32;
  return h;
}

std::uint64_t hash(const Vec3& p) {
  std::uint64_t h = 0x9e3779b97f4a7c15ULL;
  for (int k = 0; k < 3; ++k) h = mix(h ^ std::bit_cast<std::uint64_t>(p[k])) * 0xff51afd7ed558ccdULL;
  return mix(h);
}

}  // namespace

VertexTable::VertexTable(std::size_t expected) {
  points_.reserve(expected);
  grow(std::bit_ceil(std::max<std::size_t>(16, expected + expected / 2)));
}

void VertexTable::grow(std::size_t slots) {
  slots_.assign(slots, kFree);
  const std::size_t mask = slots - 1;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    std::size_t at = hash(points_[i]) & mask;
    while (slots_[at] != kFree) at = (at + 1) & mask;
    slots_[at] = static_cast<std::uint32_t>(i);
  }
}

std::uint32_t VertexTable::add(const Vec3& point) {
  const Vec3 p = point + Vec3::Zero();  // turns -0 into +0
  if (3 * (points_.size() + 1) > 2 * slots_.size()) grow(2 * slots_.size());
  const std::size_t mask = slots_.size() - 1;
  std::size_t at = hash(p) & mask;
  for (; slots_[at] != kFree; at = (at + 1) & mask) {
    if (points_[slots_[at]] == p) return slots_[at];
  }
  const auto index = static_cast<std::uint32_t>(points_.size());
  slots_[at] = index;
  points_.push_back(p);
  return index;
}

TriangleMesh weld(const TriangleMesh& mesh) {
  VertexTable table(mesh.vertices.size());
  std::vector<std::uint32_t> renamed(mesh.vertices.size(), kFree);
  TriangleMesh out;
  out.triangles.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    Triangle n{};
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& name = renamed[t[k]];
      if (name == kFree) name = table.add(mesh.vertices[t[k]]);
      n[k] = name;
    }
    out.triangles.push_back(n);
  }
  out.vertices = table.take();
  return out;
}

void drop_unused_vertices(TriangleMesh& mesh) {
  std::vector<std::uint32_t> renamed(mesh.vertices.size(), kFree);
  for (const Triangle& t : mesh.triangles) {
    for (std::uint32_t v : t) renamed[v] = 0;
  }
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < renamed.size(); ++i) {
    if (renamed[i] == kFree) continue;
    mesh.vertices[count] = mesh.vertices[i];
    renamed[i] = count++;
  }
  mesh.vertices.resize(count);
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& v : t) v = renamed[v];
  }
}

}  // namespace voidpath::mesh
