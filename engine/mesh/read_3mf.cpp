#include "engine/mesh/read_model.h"
#include "engine/mesh/text_scan.h"
#include "engine/mesh/threemf_part.h"
#include "engine/mesh/weld.h"
#include "engine/mesh/xml_stream.h"

#include <algorithm>
#include <set>

#include <Eigen/LU>

namespace voidpath::mesh {

namespace {

constexpr std::string_view kRelationships = "_rels/.rels";
constexpr std::string_view kModelRelation = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";
/// Objects put in place altogether; components that name components can multiply without end.
constexpr std::size_t kMaxUses = 1'000'000;
/// Components within components; keeps the recursion shallow.
constexpr std::size_t kMaxDepth = 64;

std::string root_part(const FileBytes& file, ZipArchive& zip) {
  const std::string rels(kRelationships);
  if (!zip.has(rels)) refuse(file, "no 3MF: the archive has no part " + rels);
  std::string target;
  XmlStream xml(file, rels,
                {[&](std::string_view name, std::string_view, const XmlAttributes& a) {
                   if (name != "Relationship" || !target.empty()) return;
                   const char* type = a.find("Type");
                   const char* to = a.find("Target");
                   if (type && to && type == kModelRelation) target = part_name(to, "");
                 },
                 {}});
  zip.read(rels, [&](std::string_view piece) { xml.feed(piece); });
  xml.finish();
  if (target.empty()) refuse(file, "part " + rels + ": it names no 3D model part");
  if (!zip.has(target))
    refuse(file, "part " + rels + ": it names the model " + target + ", which is missing");
  return target;
}

Placement after(const Placement& outer, const Placement& inner) {
  return {outer.linear * inner.linear, outer.linear * inner.shift + outer.shift};
}

class Assembly {
 public:
  Assembly(const FileBytes& file, const ImportOptions& options, const run::Context& ctx)
      : file_(file), options_(options), ctx_(ctx), zip_(file, options.max_bytes) {}

  RawModel read() {
    const std::string root = root_part(file_, zip_);
    const ThreeMfPart& part = load(root);
    if (!part.has_build) refuse(file_, "part " + root + ": there is no build, so nothing says what to print");
    if (part.items.empty()) refuse(file_, "part " + root + ": the build has no items");
    std::size_t skipped = 0;
    for (const ThreeMfUse& item : part.items) {
      if (!item.printable) {
        ++skipped;
        continue;
      }
      place(item, root, Placement{});
    }
    if (skipped > 0) note(std::to_string(skipped) + " items marked as not printable left out");
    if (part.items.size() - skipped > 1) {
      note(std::to_string(part.items.size() - skipped) + " items in the build, taken as one part");
    }
    if (all_.triangles.empty()) {
      refuse(file_, "part " + root + ": nothing in the build is a triangle mesh" +
                        (other_.empty() ? "" : "; object " + other_));
    }
    if (!other_.empty()) note("left out: object " + other_);
    for (Vec3& v : all_.vertices) v *= part.unit_mm;
    RawModel model;
    model.mesh = weld(all_);
    model.format = "3mf";
    model.notes = std::move(notes_);
    return model;
  }

 private:
  void note(std::string text) { notes_.push_back(std::move(text)); }

  const ThreeMfPart& load(const std::string& name) {
    const auto found = parts_.find(name);
    if (found != parts_.end()) return found->second;
    ThreeMfPart part = read_threemf_part(file_, zip_, name, options_, ctx_);
    for (std::string& n : part.notes) note(std::move(n));
    return parts_.emplace(name, std::move(part)).first->second;
  }

  void place(const ThreeMfUse& use, const std::string& from, const Placement& outer) {
    const std::string& part = use.part.empty() ? from : use.part;
    const auto& objects = load(part).objects;
    const auto found = objects.find(use.object);
    if (found == objects.end()) {
      refuse(file_, "part " + from + ": object " + in_quotes(use.object) + " is used, but " +
                        (use.part.empty() ? "there is none" : part + " has none"));
    }
    if (++uses_ > kMaxUses) refuse(file_, "part " + from + ": the components multiply beyond all measure");
    if (uses_ % 1024 == 0) ctx_.check();
    const ThreeMfObject& object = found->second;
    if (std::find(open_.begin(), open_.end(), &object) != open_.end()) {
      refuse(file_, "part " + part + ": object " + in_quotes(use.object) + " contains itself");
    }
    if (open_.size() >= kMaxDepth) {
      refuse(file_, "part " + part + ": components nested deeper than " + std::to_string(kMaxDepth));
    }
    if (object.type != "model" && object.type != "surface") {
      if (noted_types_.insert(object.type).second)
        note("objects of type " + in_quotes(object.type) + " left out");
      return;
    }
    const Placement here = after(outer, use.placement);
    if (!here.linear.allFinite() || !here.shift.allFinite()) {
      refuse(file_, "part " + from + ": the transforms of object " + in_quotes(use.object) + " overflow");
    }
    if (object.mesh.triangles.empty() && object.components.empty()) {
      other_ = in_quotes(use.object) + (object.other_content.empty() ? " is empty"
                                                                     : " holds <" + object.other_content +
                                                                           "> instead, which is not read");
    }
    append(object.mesh, here);
    open_.push_back(&object);
    for (const ThreeMfUse& component : object.components) place(component, part, here);
    open_.pop_back();
  }

  void append(const TriangleMesh& mesh, const Placement& place) {
    if (mesh.triangles.size() > options_.max_triangles - all_.triangles.size() ||
        mesh.vertices.size() >
            options_.max_triangles - std::min(options_.max_triangles, all_.vertices.size())) {
      refuse(file_, "more than " + std::to_string(options_.max_triangles) + " triangles in the build");
    }
    if (mesh.triangles.empty()) return;
    const auto base = static_cast<std::uint32_t>(all_.vertices.size());
    for (const Vec3& v : mesh.vertices) {
      const Vec3 p = place.linear * v + place.shift;
      if (!p.allFinite()) refuse(file_, "a transform moves a vertex beyond all numbers");
      all_.vertices.push_back(p);
    }
    const bool mirrored = place.linear.determinant() < 0;
    for (const Triangle& t : mesh.triangles) {
      const Triangle n{base + t[0], base + t[1], base + t[2]};
      all_.triangles.push_back(mirrored ? Triangle{n[0], n[2], n[1]} : n);
    }
  }

  const FileBytes& file_;
  const ImportOptions& options_;
  const run::Context& ctx_;
  ZipArchive zip_;
  std::map<std::string, ThreeMfPart> parts_;
  TriangleMesh all_;
  std::vector<std::string> notes_;
  std::set<std::string> noted_types_;
  std::string other_;
  std::vector<const ThreeMfObject*> open_;  ///< the chain of objects being placed
  std::size_t uses_ = 0;
};

}  // namespace

RawModel read_3mf(const FileBytes& file, const ImportOptions& options, const run::Context& ctx) {
  return Assembly(file, options, ctx).read();
}

}  // namespace voidpath::mesh
