#include "engine/mesh/write.h"

#include "engine/mesh/text_scan.h"

#include <array>
#include <charconv>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>

#include <unistd.h>

namespace voidpath::mesh {

namespace {

void append_number(std::string& out, double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  out.append(text.data(), end);
}

std::string as_obj(const TriangleMesh& mesh) {
  std::string out = "# voidpath, mm\n";
  for (const Vec3& v : mesh.vertices) {
    out += 'v';
    for (int k = 0; k < 3; ++k) append_number(out += ' ', v[k]);
    out += '\n';
  }
  for (const Triangle& t : mesh.triangles) {
    out += 'f';
    for (const std::uint32_t v : t) (out += ' ') += std::to_string(v + std::uint64_t{1});
    out += '\n';
  }
  return out;
}

std::string as_stl(const TriangleMesh& mesh) {
  constexpr std::size_t kHeader = 80, kFacet = 50;
  std::string out(kHeader + 4 + kFacet * mesh.triangles.size(), '\0');
  // Not beginning with "solid", which would pass for ASCII.
  constexpr std::string_view kTitle = "voidpath binary STL, mm";
  std::memcpy(out.data(), kTitle.data(), kTitle.size());
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  std::memcpy(out.data() + kHeader, &count, sizeof count);
  char* at = out.data() + kHeader + 4;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vec3 normal = (b - a).cross(c - a).normalized();
    for (const Vec3& v : {normal, a, b, c}) {
      const Eigen::Vector3f f = v.cast<float>();
      std::memcpy(at, f.data(), 12);
      at += 12;
    }
    at += 2;
  }
  return out;
}

}  // namespace

void write_model(const TriangleMesh& mesh, const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  std::string bytes;
  if (same_word(extension, ".obj")) {
    bytes = as_obj(mesh);
  } else if (same_word(extension, ".stl")) {
    bytes = as_stl(mesh);
  } else {
    throw std::runtime_error(file.string() + ": models are written as .obj or .stl");
  }
  // Hidden, so that whoever watches the folder for models passes it over.
  const auto part =
      file.parent_path() / ("." + file.filename().string() + "." + std::to_string(getpid()) + ".part");
  std::ofstream out(part, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(part, file, error);
  if (!out || error) {
    const std::string why = error ? error.message() : std::strerror(errno);
    std::filesystem::remove(part, error);
    throw std::runtime_error(file.string() + ": cannot be written: " + why);
  }
}

}  // namespace voidpath::mesh
