#pragma once

#include "engine/mesh/triangle_mesh.h"

#include <filesystem>

namespace voidpath::mesh {

/// Writes OBJ or binary STL by the file's extension, to a temporary beside it and renamed into place.
/// Throws std::runtime_error with file and reason.
void write_model(const TriangleMesh& mesh, const std::filesystem::path& file);

}  // namespace voidpath::mesh
