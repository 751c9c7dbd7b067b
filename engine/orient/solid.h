#pragma once

#include "engine/mesh/triangle_mesh.h"
#include "engine/orient/lanes.h"
#include "engine/run/context.h"

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace voidpath::orient {

using geom::Vec3;
using Index = std::uint32_t;
inline constexpr Index kNone = std::numeric_limits<Index>::max();

/// How the contours of a shell bound what is filled, by the non-zero winding rule.
enum class Wall : std::uint8_t {
  outward,    ///< filled inside of it, as the facets look: counter-clockwise contours are outer ones
  swallowed,  ///< filled on both sides: bounds nothing
};

/// A mesh made ready for being looked at from many directions; read-only after prepare_solid(), shared by
/// all threads. Coordinates are taken about the middle of the bounding box.
struct Solid {
  std::vector<Vec3> vertices;
  std::vector<mesh::Triangle> triangles;
  /// Facet across the edge from corner k to k + 1; kNone where the mesh is open. Where more than two facets
  /// share an edge, those that enclose material between them are joined: bodies that touch stay apart.
  std::vector<mesh::Triangle> beside;
  std::vector<Index> shell_of;    ///< per facet: connected over `beside`
  std::vector<Wall> shell_walls;  ///< per shell
  /// Per shell: it meets itself or another shell somewhere, so its slices need the fill rule.
  std::vector<std::uint8_t> shell_tangled;
  /// Pairs of facets that run through one another or lie on one another.
  std::vector<std::pair<Index, Index>> contacts;
  std::vector<Vec3> vertex_normals;                        ///< area-weighted, unit; zero where undefined
  std::vector<Vec3> triangle_normals;                      ///< unit; zero for slivers without area
  Columns areas;                                           ///< per facet: area times normal, mm²
  Columns middles;                                         ///< per facet: centroid
  NearColumns vertex_normals_near, triangle_normals_near;  ///< to single precision
  /// Facets at each vertex: facets_at[first_facet_at[v]] to facets_at[first_facet_at[v + 1]].
  std::vector<Index> first_facet_at, facets_at;
  Vec3 centre_of_mass = Vec3::Zero();
  double signed_volume_mm3 = 0;            ///< as the divergence theorem has it: overlaps count twice
  double volume_mm3 = 0;                   ///< filled, overlaps counted once
  geom::Mat3 spread = geom::Mat3::Zero();  ///< second moments of the surface about its centroid, mm²
  double box_mm3 = 0;                      ///< of the bounding box as delivered
  double radius_mm = 0;                    ///< of a ball about the origin that holds everything
};

/// Throws run::Stopped.
Solid prepare_solid(const mesh::TriangleMesh& mesh, const run::Context& ctx);

/// Only what tells how the part stands: no contacts, walls of shells, filled volume, spread and columns.
Solid prepare_standing(const mesh::TriangleMesh& mesh, const run::Context& ctx);

}  // namespace voidpath::orient
