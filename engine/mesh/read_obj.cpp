#include "engine/mesh/read_model.h"
#include "engine/mesh/text_scan.h"
#include "engine/mesh/triangulate.h"
#include "engine/mesh/weld.h"

#include <algorithm>
#include <charconv>

namespace voidpath::mesh {

namespace {

/// Lines between two looks at the stop token.
constexpr std::size_t kCheckEvery = 1 << 16;

/// Hands out logical lines: a backslash at the end of a line joins the next one to it.
class ObjLines {
 public:
  explicit ObjLines(std::string_view text) : text_(text) {}

  bool next(std::string_view& line) {
    if (at_ >= text_.size()) return false;
    number_ = following_;
    line = physical();
    if (line.empty() || line.back() != '\\') return true;
    joined_.clear();
    while (!line.empty() && line.back() == '\\') {
      joined_.append(line.substr(0, line.size() - 1)).push_back(' ');
      if (at_ >= text_.size()) break;
      line = physical();
    }
    if (line.empty() || line.back() != '\\') joined_.append(line);
    line = joined_;
    return true;
  }

  std::size_t number() const { return number_; }
  double fraction() const { return static_cast<double>(at_) / static_cast<double>(text_.size()); }

 private:
  std::string_view physical() {
    std::size_t end = text_.find_first_of("\r\n", at_);
    if (end == text_.npos) end = text_.size();
    std::string_view line = text_.substr(at_, end - at_);
    if (end + 1 < text_.size() && text_[end] == '\r' && text_[end + 1] == '\n') ++end;
    at_ = std::min(end + 1, text_.size());
    ++following_;
    while (!line.empty() && (line.back() == ' ' || line.back() == '\t')) line.remove_suffix(1);
    return line;
  }

  std::string_view text_;
  std::string joined_;
  std::size_t at_ = 0;
  std::size_t number_ = 0;
  std::size_t following_ = 1;
};

class ObjReader {
 public:
  ObjReader(const FileBytes& file, const ImportOptions& options, const run::Context& ctx)
      : file_(file), options_(options), ctx_(ctx), lines_(file.bytes) {}

  RawModel read() {
    std::string_view line;
    while (lines_.next(line)) {
      if (lines_.number() % kCheckEvery == 0) {
        ctx_.check();
        ctx_.progress("import", lines_.fraction());
      }
      TokenScanner tokens(line);
      const std::string_view word = tokens.next_on_line();
      if (word == "v") {
        vertex(tokens);
      } else if (word == "f" || word == "fo") {
        face(tokens);
      } else if (word == "surf" || word == "curv") {
        ++free_forms_;
      }
    }
    if (highest_ > points_.size()) {
      refuse(file_, "line " + std::to_string(highest_line_) + ": the face names vertex " +
                        std::to_string(highest_) + ", but the file has " + std::to_string(points_.size()));
    }
    if (face_ends_.empty()) {
      refuse(file_, "the file holds no faces (" + std::to_string(points_.size()) + " vertices" +
                        (free_forms_ > 0 ? "; its free-form surfaces are not read)" : ")"));
    }
    return finish();
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    refuse(file_, "line " + std::to_string(lines_.number()) + ": " + what);
  }

  void vertex(TokenScanner& tokens) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) {
      const std::string_view token = tokens.next_on_line();
      if (token.empty()) fail("a vertex needs three coordinates");
      if (!parse_number(token, p[k])) fail(in_quotes(token) + " is not a coordinate");
    }
    if (!p.allFinite()) fail("a coordinate is not a number (NaN or infinite)");
    if (points_.size() >= 3 * options_.max_triangles) fail("too many vertices");
    points_.push_back(p);
  }

  void face(TokenScanner& tokens) {
    const std::size_t begin = corners_.size();
    for (std::string_view t = tokens.next_on_line(); !t.empty() && t[0] != '#'; t = tokens.next_on_line()) {
      corners_.push_back(corner(t));
    }
    const std::size_t n = corners_.size() - begin;
    if (n < 3) fail("a face of " + std::to_string(n) + " corners; three are needed");
    triangles_ += n - 2;
    if (triangles_ > options_.max_triangles) {
      fail("more than " + std::to_string(options_.max_triangles) + " triangles");
    }
    face_ends_.push_back(corners_.size());
  }

  /// "7", "7/1", "7//3", "7/1/3"; negative numbers count back from the last vertex so far.
  std::uint32_t corner(std::string_view token) {
    const std::string_view number = token.substr(0, token.find('/'));
    long long index = 0;
    const auto [stop, error] = std::from_chars(number.data(), number.data() + number.size(), index);
    if (error != std::errc() || stop != number.data() + number.size()) {
      fail(in_quotes(token) + " is not a vertex number");
    }
    const auto known = static_cast<long long>(points_.size());
    if (index == 0 || index < -known || index > static_cast<long long>(3 * options_.max_triangles)) {
      fail("the face names vertex " + std::to_string(index) + ", but there are " + std::to_string(known));
    }
    if (index < 0) index += known + 1;
    // Some writers put faces before the vertices they use; the end of the file decides.
    if (static_cast<std::size_t>(index) > std::max(highest_, points_.size())) {
      highest_ = static_cast<std::size_t>(index);
      highest_line_ = lines_.number();
    }
    return static_cast<std::uint32_t>(index - 1);
  }

  RawModel finish() {
    TriangleMesh raw;
    raw.triangles.reserve(triangles_);
    std::vector<Vec3> ring;
    std::vector<Triangle> cut;
    std::size_t begin = 0, polygons = 0;
    for (const std::size_t end : face_ends_) {
      const std::uint32_t* face = corners_.data() + begin;
      const std::size_t n = end - begin;
      begin = end;
      if (n == 3) {
        raw.triangles.push_back({face[0], face[1], face[2]});
        continue;
      }
      if (++polygons % 256 == 0) ctx_.check();
      ring.clear();
      cut.clear();
      for (std::size_t k = 0; k < n; ++k) ring.push_back(points_[face[k]]);
      triangulate(ring, cut);
      for (const Triangle& t : cut) raw.triangles.push_back({face[t[0]], face[t[1]], face[t[2]]});
    }
    raw.vertices = std::move(points_);
    RawModel model;
    model.mesh = weld(raw);
    model.format = "obj";
    if (free_forms_ > 0) {
      model.notes.push_back(std::to_string(free_forms_) + " free-form curves or surfaces not read");
    }
    return model;
  }

  const FileBytes& file_;
  const ImportOptions& options_;
  const run::Context& ctx_;
  ObjLines lines_;
  std::vector<Vec3> points_;
  std::vector<std::uint32_t> corners_;  ///< of all faces, one after the other
  std::vector<std::size_t> face_ends_;  ///< into corners_
  std::size_t triangles_ = 0;
  std::size_t highest_ = 0;  ///< vertex number named before it was defined, with its line
  std::size_t highest_line_ = 0;
  std::size_t free_forms_ = 0;
};

}  // namespace

bool looks_like_obj(std::string_view bytes) {
  const std::string_view head = bytes.substr(0, 4096);
  if (head.find('\0') != head.npos) return false;
  TokenScanner scan(head);
  for (std::string_view word = scan.next(); !word.empty(); scan.skip_line(), word = scan.next()) {
    double number = 0;
    if (word == "v" && parse_number(scan.next_on_line(), number)) return true;
  }
  return false;
}

RawModel read_obj(const FileBytes& file, const ImportOptions& options, const run::Context& ctx) {
  return ObjReader(file, options, ctx).read();
}

}  // namespace voidpath::mesh
