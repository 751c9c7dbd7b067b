#pragma once

#include "engine/mesh/import.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <unistd.h>

namespace voidpath::test {

/// A folder of its own, gone with the object.
class TempFolder {
 public:
  TempFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "voidpath-mesh-XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path file(const std::string& name, std::string_view bytes) const {
    std::ofstream(path_ / name, std::ios::binary) << bytes;
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

/// Imports bytes as a file of this name.
inline mesh::Import import_bytes(const std::string& name, std::string_view bytes,
                                 const mesh::ImportOptions& options = {}) {
  const TempFolder folder;
  return mesh::import_model(folder.file(name, bytes), options);
}

/// What the refusal says; "accepted" when there is none.
inline std::string refusal(const std::string& name, std::string_view bytes,
                           const mesh::ImportOptions& options = {}) {
  try {
    import_bytes(name, bytes, options);
    return "accepted";
  } catch (const mesh::ImportError& e) {
    return e.what();
  }
}

inline std::uint32_t crc32(std::string_view bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int k = 0; k < 8; ++k) crc = (crc >> 1) ^ (crc & 1u ? 0xedb88320u : 0u);
  }
  return ~crc;
}

/// A part of a zip archive: stored as it is, unless `packed` holds a deflate stream of it.
struct ZipPart {
  std::string name;
  std::string bytes;
  std::string packed = {};
  std::uint32_t unpacked_size = 0;
};

inline std::string zip(const std::vector<ZipPart>& parts) {
  std::string out, directory;
  const auto u16 = [](std::string& s, std::size_t v) {
    s += static_cast<char>(v & 0xff);
    s += static_cast<char>(v >> 8 & 0xff);
  };
  const auto u32 = [&](std::string& s, std::size_t v) {
    u16(s, v & 0xffff);
    u16(s, v >> 16);
  };
  for (const ZipPart& p : parts) {
    const bool deflated = !p.packed.empty();
    const std::string& data = deflated ? p.packed : p.bytes;
    const std::size_t at = out.size();
    std::string common;
    u16(common, 20);
    u16(common, 0);
    u16(common, deflated ? 8 : 0);
    u32(common, 0);
    u32(common, crc32(p.bytes));
    u32(common, data.size());
    u32(common, deflated ? p.unpacked_size : p.bytes.size());
    u16(common, p.name.size());
    u16(common, 0);
    out += std::string("PK\x03\x04") + common + p.name + data;
    directory += std::string("PK\x01\x02");
    u16(directory, 20);
    directory += common;
    u16(directory, 0);
    u16(directory, 0);
    u16(directory, 0);
    u32(directory, 0);
    u32(directory, at);
    directory += p.name;
  }
  const std::size_t at = out.size();
  out += directory + "PK\x05\x06";
  u32(out, 0);
  u16(out, parts.size());
  u16(out, parts.size());
  u32(out, directory.size());
  u32(out, at);
  u16(out, 0);
  return out;
}

}  // namespace voidpath::test
