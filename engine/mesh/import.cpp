#include "engine/mesh/import.h"

#include "engine/mesh/read_model.h"
#include "engine/mesh/text_scan.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>

namespace voidpath::mesh {

namespace {

/// mm. Smaller than this in every axis, the file was hardly meant in millimetres.
constexpr double kTiny = 5;
/// Mean thickness (twice volume over surface) as a fraction of the size, below which a surface that is
/// open encloses nothing.
constexpr double kNoThickness = 1e-4;
/// A facet that stands alone has an open edge on each side; with more than this share of all sides open the
/// facets do not connect to a surface.
constexpr double kMaxOpenShare = 0.5;
/// Size in float steps below which the coordinates of an STL have lost visible precision: a tenth of a
/// thousandth of the part.
constexpr double kFloatStep = 6e-8, kVisibleStep = 1e-3;

std::string fixed(double value) {
  char text[64];
  const int digits = std::abs(value) >= 100 ? 0 : std::abs(value) >= 1 ? 2 : 4;
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, digits).ptr;
  return value < 1e15 ? std::string(text, end) : "more than 1e15";
}

std::string size_text(const Vec3& s) {
  return fixed(s.x()) + " x " + fixed(s.y()) + " x " + fixed(s.z()) + " mm";
}

std::string extension(const std::filesystem::path& file) {
  std::string e = file.extension().string();
  for (char& c : e) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return e;
}

std::string read_bytes(const std::filesystem::path& path, const std::string& name,
                       const ImportOptions& options) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw ImportError(name + ": no such file");
  if (!std::filesystem::is_regular_file(status)) throw ImportError(name + ": not a file");
  const auto size = std::filesystem::file_size(path, error);
  if (error) throw ImportError(name + ": " + error.message());
  if (size == 0) throw ImportError(name + ": the file is empty (0 bytes)");
  if (size > options.max_bytes) {
    throw ImportError(name + ": " + std::to_string(size) + " bytes, more than the " +
                      std::to_string(options.max_bytes) + " that are read");
  }
  std::string bytes(size, '\0');
  std::ifstream in(path, std::ios::binary);
  if (!in) throw ImportError(name + ": cannot be opened for reading");
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (static_cast<std::size_t>(in.gcount()) != bytes.size()) {
    throw ImportError(name + ": reading stopped at byte " + std::to_string(in.gcount()) + " of " +
                      std::to_string(bytes.size()));
  }
  return bytes;
}

bool is_utf16(std::string_view b) {
  if (b.starts_with("\xff\xfe") || b.starts_with("\xfe\xff")) return true;
  // Without a mark: Latin text then has a zero in every other byte.
  std::size_t zeros[2] = {0, 0};
  const std::size_t n = std::min<std::size_t>(b.size(), 64);
  for (std::size_t i = 0; i < n; ++i) zeros[i % 2] += b[i] == '\0' ? 1u : 0u;
  return n >= 16 && ((zeros[0] == n / 2 && zeros[1] == 0) || (zeros[1] == n / 2 && zeros[0] == 0));
}

RawModel read(const FileBytes& whole, const std::string& ext, const ImportOptions& options,
              const run::Context& ctx) {
  FileBytes file = whole;
  if (file.bytes.starts_with("PK\x03\x04") || ext == ".3mf") return read_3mf(file, options, ctx);
  if (is_stl(file.bytes) && !is_utf16(file.bytes)) return read_stl(file, options, ctx);
  if (is_utf16(file.bytes)) refuse(file, "the text is UTF-16; STL and OBJ are read as ASCII or UTF-8");
  if (file.bytes.starts_with("\xef\xbb\xbf")) file.bytes.remove_prefix(3);
  if (ext == ".obj" || (ext != ".stl" && looks_like_obj(file.bytes))) return read_obj(file, options, ctx);
  if (ext == ".stl" && !looks_like_obj(file.bytes)) return read_stl(file, options, ctx);
  if (ext == ".stl") {
    RawModel model = read_obj(file, options, ctx);
    model.notes.push_back("named .stl, but it is an OBJ file");
    return model;
  }
  refuse(file, "begins with " + in_quotes(TokenScanner(file.bytes).next()) + ": not STL, OBJ or 3MF");
}

void check_size(const FileBytes& file, const Vec3& size, const ImportOptions& options) {
  if (size.maxCoeff() <= options.max_size_mm) return;
  refuse(file, "the part measures " + size_text(size) + ", more than " + fixed(options.max_size_mm) +
                   " mm; its unit is probably not the millimetre: scale it, e.g. by 0.001 if the numbers are "
                   "micrometres");
}

void note_size(const Vec3& size, double far, Import& out) {
  if (size.maxCoeff() < kTiny) {
    out.notes.push_back("only " + size_text(size) +
                        ": if the file is in inches, use --scale 25.4; if in metres, --scale 1000");
  }
  if (out.format.starts_with("stl") && far * kFloatStep > kVisibleStep * size.maxCoeff()) {
    out.notes.push_back("the part lies " + fixed(far) + " mm from the origin, where STL numbers are " +
                        fixed(2 * far * kFloatStep) + " mm apart: details are lost");
  }
}

/// Refuses what no repair could make a solid.
void check_solid(const FileBytes& file, const Import& import) {
  const TriangleMesh& mesh = import.mesh;
  if (mesh.triangles.empty()) refuse(file, "none of the facets has an area");
  const double sides = 3 * static_cast<double>(mesh.triangles.size());
  const std::size_t open = import.repairs.open_edges_left;
  if (static_cast<double>(open) > kMaxOpenShare * sides) {
    refuse(file, "the facets do not connect to a surface: " + std::to_string(open) + " open edges at " +
                     std::to_string(mesh.triangles.size()) + " facets remain after repair");
  }
  const double thickness = 2 * volume(mesh) / surface_area(mesh);
  if (!(thickness > kNoThickness * bounds(mesh).size().norm())) {
    refuse(file, "the surface encloses no volume: " + std::to_string(mesh.triangles.size()) + " facets of " +
                     fixed(surface_area(mesh)) + " mm2, " + std::to_string(open) + " open edges");
  }
}

}  // namespace

void refuse(const FileBytes& file, const std::string& place_and_what) {
  throw ImportError(file.name + ": " + place_and_what);
}

bool is_model_name(const std::filesystem::path& file) {
  const std::string e = extension(file);
  return e == ".stl" || e == ".obj" || e == ".3mf";
}

Import import_model(const std::filesystem::path& path, const ImportOptions& options,
                    const run::Context& ctx) {
  ctx.check();
  const std::string name = path.filename().string();
  std::string bytes = read_bytes(path, name, options);
  FileBytes file{name, bytes};
  RawModel raw = read(file, extension(path), options, ctx);
  file.bytes = {};
  bytes = {};

  Import out;
  out.format = std::move(raw.format);
  out.notes = std::move(raw.notes);
  out.mesh = std::move(raw.mesh);
  if (options.scale != 1.0) {
    for (Vec3& v : out.mesh.vertices) v *= options.scale;
  }
  const Bounds box = bounds(out.mesh);
  check_size(file, box.size(), options);
  note_size(box.size(), box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs()).maxCoeff(), out);
  ctx.check();
  out.delivered = inspect(out.mesh);
  ctx.check();
  out.repairs = repair(out.mesh);
  check_solid(file, out);
  ctx.progress("import", 1);
  return out;
}

}  // namespace voidpath::mesh
