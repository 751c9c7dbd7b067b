#pragma once

#include <array>
#include <optional>

#include "engine/mesh/triangle_mesh.h"

namespace voidpath::pipeline {

/// Turning about the build axis changes no criterion, so it is free to make a part fit. The smallest turn
/// (radians, counter-clockwise; a quarter turn is tried right after none) with which the part's bounding
/// rectangle fits into the bed less `margin_mm` on every side; empty when none does.
std::optional<double> bed_turn(const mesh::TriangleMesh& mesh, const std::array<double, 2>& bed_mm, double margin_mm);

/// Turned about z by `angle`, centred on x = y = 0 again.
mesh::TriangleMesh turned_about_z(const mesh::TriangleMesh& mesh, double angle);

}  // namespace voidpath::pipeline
