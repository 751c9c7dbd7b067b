#pragma once

#include "engine/mesh/inspect.h"
#include "engine/mesh/repair.h"
#include "engine/mesh/triangle_mesh.h"
#include "engine/run/context.h"

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace voidpath::mesh {

/// A file that is refused. what() is one sentence for the user: file, place (line, byte offset, facet or
/// part inside the archive) and what is wrong there.
class ImportError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct ImportOptions {
  double scale = 1.0;           ///< multiplies every length after the file's own unit
  double max_size_mm = 2000.0;  ///< larger in any axis is refused: no printer prints it, units are wrong
  std::size_t max_triangles = 20'000'000;
  std::size_t max_bytes = std::size_t{2} << 30;  ///< also the limit on what an archive may unpack to
};

struct Import {
  TriangleMesh mesh;               ///< welded and repaired: what is oriented and sliced
  MeshReport delivered;            ///< the file as it was, welded exactly
  RepairReport repairs;            ///< what was changed
  std::string format;              ///< "stl-binary", "stl-ascii", "obj", "3mf"
  std::vector<std::string> notes;  ///< for the user: odd but harmless things met in the file
};

/// Reads STL (binary or ASCII, told apart by content), OBJ or 3MF (several items, components,
/// transforms, units), welds, inspects and repairs. The format is found by content first, extension
/// second. Never writes to the file.
/// Throws ImportError; run::Stopped. Peak memory is at most some 10 × the size of the mesh.
Import import_model(const std::filesystem::path& file, const ImportOptions& options = {},
                    const run::Context& ctx = {});

/// Whether the name ends like a model that can be imported (.stl .obj .3mf, any case).
bool is_model_name(const std::filesystem::path& file);

}  // namespace voidpath::mesh
