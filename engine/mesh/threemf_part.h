#pragma once

#include "engine/mesh/read_model.h"
#include "engine/mesh/zip_archive.h"

#include <array>
#include <map>
#include <string>
#include <vector>

namespace voidpath::mesh {

/// The 4x3 matrix of a 3MF transform attribute: p' = linear * p + shift.
struct Placement {
  geom::Mat3 linear = geom::Mat3::Identity();
  Vec3 shift = Vec3::Zero();
};

/// Another object put in place: a component, or an item of the build.
struct ThreeMfUse {
  std::string part;  ///< that holds the object; empty: the same one
  std::string object;
  Placement placement;
  bool printable = true;
};

struct ThreeMfObject {
  std::string type = "model";
  TriangleMesh mesh;  ///< in the file's unit, indices checked
  std::vector<ThreeMfUse> components;
  std::string other_content;  ///< an element that stands where mesh or components should
};

/// One model part of a 3MF archive, as written.
struct ThreeMfPart {
  double unit_mm = 1;
  std::map<std::string, ThreeMfObject> objects;
  std::vector<ThreeMfUse> items;
  bool has_build = false;
  std::vector<std::string> notes;
};

/// Throws ImportError, run::Stopped.
ThreeMfPart read_threemf_part(const FileBytes& file, ZipArchive& zip, const std::string& part,
                              const ImportOptions& options, const run::Context& ctx);

/// "/3D/a.model" or "a.model" seen from `base` as the name of a part in the archive.
std::string part_name(const std::string& target, const std::string& base);

}  // namespace voidpath::mesh
