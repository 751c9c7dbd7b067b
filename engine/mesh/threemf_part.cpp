#include "engine/mesh/threemf_part.h"

#include "engine/mesh/text_scan.h"
#include "engine/mesh/xml_stream.h"

#include <charconv>
#include <cmath>
#include <cstring>

#include <Eigen/LU>

namespace voidpath::mesh {

namespace {

constexpr std::string_view kProduction = "3dmanufacturing/production";

bool is_core(std::string_view space) {
  return space.empty() || space.find("3dmanufacturing/core/") != space.npos ||
         space == "http://schemas.microsoft.com/3dmanufacturing/2013/01";
}

/// mm in the named unit of the core specification; 0 when there is no such unit.
double unit_in_mm(std::string_view unit) {
  constexpr std::pair<std::string_view, double> kUnits[] = {{"micron", 0.001},  {"millimeter", 1},
                                                            {"centimeter", 10}, {"inch", 25.4},
                                                            {"foot", 304.8},    {"meter", 1000}};
  for (const auto& [name, mm] : kUnits) {
    if (unit == name) return mm;
  }
  return 0;
}

class PartReader {
 public:
  PartReader(const FileBytes& file, ZipArchive& zip, std::string part, const ImportOptions& options,
             const run::Context& ctx)
      : zip_(zip),
        name_(std::move(part)),
        options_(options),
        ctx_(ctx),
        xml_(file, name_,
             {[this](auto name, auto space, const auto& attributes) { begin(name, space, attributes); },
              [this](auto name, auto space) { end(name, space); }}) {}

  ThreeMfPart read() {
    zip_.read(name_, [this](std::string_view piece) {
      ctx_.check();
      xml_.feed(piece);
    });
    xml_.finish();
    return std::move(part_);
  }

 private:
  void begin(std::string_view name, std::string_view space, const XmlAttributes& a) {
    if (!is_core(space)) {
      if (object_ && object_->other_content.empty()) object_->other_content = name;
      return;
    }
    if (name == "vertex") {
      vertex(a);
    } else if (name == "triangle") {
      triangle(a);
    } else if (name == "object") {
      object(a);
    } else if (name == "component") {
      if (!object_) xml_.fail("a component outside an object");
      object_->components.push_back(use(a, "component"));
    } else if (name == "item") {
      if (!part_.has_build) xml_.fail("an item outside the build");
      part_.items.push_back(use(a, "item"));
    } else if (name == "build") {
      part_.has_build = true;
    } else if (name == "model") {
      model(a);
    } else if (!saw_model_) {
      xml_.fail("the part begins with <" + std::string(name) + ">, not <model>");
    }
  }

  void end(std::string_view name, std::string_view space) {
    if (!is_core(space)) return;
    if (name == "mesh" && object_) check_indices();
    if (name == "object") object_ = nullptr;
  }

  void model(const XmlAttributes& a) {
    saw_model_ = true;
    if (const char* unit = a.find("unit")) {
      part_.unit_mm = unit_in_mm(unit);
      if (part_.unit_mm == 0) xml_.fail("unit " + in_quotes(unit) + " is not one of 3MF");
    }
    if (const char* needs = a.find("requiredextensions"); needs && *needs) {
      part_.notes.push_back("the file asks for the extensions " + in_quotes(needs) +
                            "; only the plain meshes are read");
    }
  }

  void object(const XmlAttributes& a) {
    const char* id = a.find("id");
    if (!id) xml_.fail("an object without id");
    const auto [at, fresh] = part_.objects.try_emplace(id);
    if (!fresh) xml_.fail("a second object with id " + in_quotes(id));
    object_ = &at->second;
    if (const char* type = a.find("type")) object_->type = type;
  }

  void vertex(const XmlAttributes& a) {
    if (!object_) xml_.fail("a vertex outside an object");
    Vec3 p;
    constexpr std::string_view kAxes[] = {"x", "y", "z"};
    for (int k = 0; k < 3; ++k) {
      const char* text = a.find(kAxes[k]);
      if (!text) xml_.fail("a vertex without " + std::string(kAxes[k]));
      if (!parse_number(trimmed(text), p[k]) || !std::isfinite(p[k])) {
        xml_.fail(in_quotes(text) + " is not a coordinate");
      }
    }
    // No sane mesh has more corners than facets; a file of vertices alone must not fill the memory.
    if (++vertices_ > options_.max_triangles) xml_.fail("too many vertices");
    object_->mesh.vertices.push_back(p);
  }

  void triangle(const XmlAttributes& a) {
    if (!object_) xml_.fail("a triangle outside an object");
    Triangle t{};
    constexpr std::string_view kCorners[] = {"v1", "v2", "v3"};
    for (std::size_t k = 0; k < 3; ++k) {
      const char* text = a.find(kCorners[k]);
      if (!text) xml_.fail("a triangle without " + std::string(kCorners[k]));
      const std::string_view number = trimmed(text);
      const auto [stop, error] = std::from_chars(number.data(), number.data() + number.size(), t[k]);
      if (error != std::errc() || stop != number.data() + number.size()) {
        xml_.fail(in_quotes(text) + " is not a vertex number");
      }
    }
    if (++triangles_ > options_.max_triangles) {
      xml_.fail("more than " + std::to_string(options_.max_triangles) + " triangles");
    }
    object_->mesh.triangles.push_back(t);
  }

  void check_indices() {
    const TriangleMesh& mesh = object_->mesh;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      for (std::uint32_t v : mesh.triangles[i]) {
        if (v < mesh.vertices.size()) continue;
        xml_.fail("triangle " + std::to_string(i + 1) + " of the mesh that ends here names vertex " +
                  std::to_string(v) + ", but there are " + std::to_string(mesh.vertices.size()));
      }
    }
  }

  ThreeMfUse use(const XmlAttributes& a, const std::string& what) {
    ThreeMfUse u;
    const char* id = a.find("objectid");
    if (!id) xml_.fail("a" + std::string(what == "item" ? "n " : " ") + what + " without objectid");
    u.object = id;
    if (const char* path = a.find_in(kProduction, "path")) u.part = part_name(path, name_);
    if (const char* transform = a.find("transform")) u.placement = placement(transform);
    if (const char* printable = a.find("printable")) u.printable = std::strcmp(printable, "0") != 0;
    return u;
  }

  /// Twelve numbers, row by row, for row vectors: p' = (p 1) * M.
  Placement placement(const char* text) {
    TokenScanner tokens(text);
    Placement place;
    for (int i = 0; i < 12; ++i) {
      double value = 0;
      const std::string_view token = tokens.next();
      if (!parse_number(token, value) || !std::isfinite(value)) {
        xml_.fail("the transform " + in_quotes(text) + " is not twelve numbers");
      }
      if (i < 9) {
        place.linear(i % 3, i / 3) = value;
      } else {
        place.shift[i - 9] = value;
      }
    }
    if (!tokens.next().empty())
      xml_.fail("the transform " + in_quotes(text) + " has more than twelve numbers");
    if (place.linear.determinant() == 0) xml_.fail("the transform " + in_quotes(text) + " flattens the part");
    return place;
  }

  static std::string_view trimmed(std::string_view text) {
    TokenScanner tokens(text);
    const std::string_view token = tokens.next();
    return tokens.next().empty() ? token : text;
  }

  ZipArchive& zip_;
  std::string name_;
  const ImportOptions& options_;
  const run::Context& ctx_;
  XmlStream xml_;
  ThreeMfPart part_;
  ThreeMfObject* object_ = nullptr;
  std::size_t triangles_ = 0;
  std::size_t vertices_ = 0;
  bool saw_model_ = false;
};

}  // namespace

ThreeMfPart read_threemf_part(const FileBytes& file, ZipArchive& zip, const std::string& part,
                              const ImportOptions& options, const run::Context& ctx) {
  return PartReader(file, zip, part, options, ctx).read();
}

std::string part_name(const std::string& target, const std::string& base) {
  if (target.starts_with('/')) return target.substr(1);
  const std::size_t folder = base.rfind('/');
  return folder == base.npos ? target : base.substr(0, folder + 1) + target;
}

}  // namespace voidpath::mesh
