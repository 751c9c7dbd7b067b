#pragma once

#include "engine/mesh/read_model.h"

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace voidpath::mesh {

/// Reads parts of a zip archive that lies in memory. Throws ImportError with archive and part.
class ZipArchive {
 public:
  /// `max_bytes` limits what all parts together may unpack to.
  ZipArchive(const FileBytes& file, std::size_t max_bytes);
  ~ZipArchive();
  ZipArchive(const ZipArchive&) = delete;
  ZipArchive& operator=(const ZipArchive&) = delete;

  /// Part names are compared without regard to case, as package conventions want it.
  bool has(const std::string& part) const;
  /// Unpacks a part piece by piece; checks its checksum at the end.
  void read(const std::string& part, const std::function<void(std::string_view)>& piece);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voidpath::mesh
