#pragma once

#include "engine/mesh/import.h"

#include <string>
#include <string_view>
#include <vector>

namespace voidpath::mesh {

/// What a reader makes of a file: mm, welded exactly, nothing repaired, every coordinate finite.
struct RawModel {
  TriangleMesh mesh;
  std::string format;
  std::vector<std::string> notes;  ///< odd but harmless things, a sentence each
};

/// A whole file in memory; `name` stands in messages.
struct FileBytes {
  std::string name;
  std::string_view bytes;
};

/// Throws ImportError: "name: place: what".
[[noreturn]] void refuse(const FileBytes& file, const std::string& place_and_what);

/// STL, binary or ASCII. Throws ImportError, run::Stopped; so do the other readers.
RawModel read_stl(const FileBytes& file, const ImportOptions& options, const run::Context& ctx);
/// Wavefront OBJ: vertices and faces of any number of corners; everything else is passed over.
RawModel read_obj(const FileBytes& file, const ImportOptions& options, const run::Context& ctx);
/// 3MF core and production extension: all build items, placed as the file says.
RawModel read_3mf(const FileBytes& file, const ImportOptions& options, const run::Context& ctx);

/// Whether the bytes are STL for certain: ASCII with facets, or binary whose length fits its count.
bool is_stl(std::string_view bytes);
/// Whether the text has OBJ vertex lines near its beginning.
bool looks_like_obj(std::string_view bytes);

}  // namespace voidpath::mesh
