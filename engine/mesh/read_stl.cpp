#include "engine/mesh/read_model.h"
#include "engine/mesh/text_scan.h"
#include "engine/mesh/triangulate.h"
#include "engine/mesh/weld.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace voidpath::mesh {

namespace {

constexpr std::size_t kHeaderBytes = 80;
constexpr std::size_t kFacetsBegin = 84;
constexpr std::size_t kFacetBytes = 50;
/// Facets between two looks at the stop token.
constexpr std::size_t kCheckEvery = 1 << 16;
/// STL facets stand alone, so a few without numbers can be left out and the hole closed; with more than
/// this share of them the exporter failed and the part is not what its author meant.
constexpr double kMaxBadShare = 0.01;
/// ASCII facets have three corners; some exporters write quads. Anything longer is damage.
constexpr std::size_t kMaxCorners = 64;

static_assert(std::endian::native == std::endian::little, "binary STL is read as it lies in memory");

std::uint32_t facet_count(std::string_view bytes) {
  std::uint32_t n = 0;
  std::memcpy(&n, bytes.data() + kHeaderBytes, sizeof n);
  return n;
}

bool length_fits_count(std::string_view bytes) {
  return bytes.size() >= kFacetsBegin &&
         bytes.size() == kFacetsBegin + kFacetBytes * std::size_t{facet_count(bytes)};
}

bool is_ascii_stl(std::string_view bytes) {
  TokenScanner scan(bytes.substr(0, 4096));
  if (!same_word(scan.next(), "solid")) return false;
  scan.skip_line();
  // A binary file may begin with "solid" too, but no line of it then begins with one of these.
  for (std::string_view token = scan.next(); !token.empty(); scan.skip_line(), token = scan.next()) {
    if (same_word(token, "facet") || same_word(token, "endsolid")) return true;
  }
  return false;
}

/// Collects facets that are made of finite numbers, counts the others.
class FacetSink {
 public:
  FacetSink(const FileBytes& file, const ImportOptions& options, std::size_t expected)
      : file_(file), max_(options.max_triangles), table_(expected / 2 + 16) {
    model_.mesh.triangles.reserve(std::min(expected, max_));
  }

  void add(const Vec3& a, const Vec3& b, const Vec3& c, std::size_t number) {
    if (!a.allFinite() || !b.allFinite() || !c.allFinite()) {
      if (bad_++ == 0) first_bad_ = number;
      return;
    }
    if (model_.mesh.triangles.size() >= max_) {
      refuse(file_, "more than " + std::to_string(max_) + " triangles");
    }
    model_.mesh.triangles.push_back({table_.add(a), table_.add(b), table_.add(c)});
  }

  /// `unit_word` tells what the numbers given to add() count: "facet" or "line".
  RawModel finish(std::string format, const std::string& unit_word) {
    const std::size_t good = model_.mesh.triangles.size();
    if (bad_ > 0) {
      const std::string where = unit_word + " " + std::to_string(first_bad_);
      if (static_cast<double>(bad_) > std::max(1.0, kMaxBadShare * static_cast<double>(good)) || good == 0) {
        refuse(file_, where + ": a corner is not a number (NaN or infinite), as in " + std::to_string(bad_) +
                          " of " + std::to_string(good + bad_) + " facets");
      }
      model_.notes.push_back(std::to_string(bad_) + " of " + std::to_string(good + bad_) +
                             " facets left out because a corner is not a number (first at " + where + ")");
    }
    if (good == 0) refuse(file_, "the file holds no facets");
    model_.mesh.vertices = table_.take();
    model_.format = std::move(format);
    return std::move(model_);
  }

  void note(std::string text) { model_.notes.push_back(std::move(text)); }

 private:
  const FileBytes& file_;
  std::size_t max_;
  VertexTable table_;
  RawModel model_;
  std::size_t bad_ = 0;
  std::size_t first_bad_ = 0;
};

RawModel read_binary(const FileBytes& file, const ImportOptions& options, const run::Context& ctx) {
  const std::string_view bytes = file.bytes;
  const std::size_t count = facet_count(bytes);
  const std::size_t whole = (bytes.size() - kFacetsBegin) / kFacetBytes;
  if (count == 0) {
    refuse(file, "binary STL whose header at byte 80 announces 0 facets (" + std::to_string(bytes.size()) +
                     " bytes)");
  }
  if (count > whole) {
    refuse(file, "binary STL cut short: the header at byte 80 announces " + std::to_string(count) +
                     " facets (" + std::to_string(kFacetsBegin + kFacetBytes * count) +
                     " bytes), but the file has " + std::to_string(bytes.size()) + " bytes, which is " +
                     std::to_string(whole) + " whole facets");
  }
  FacetSink sink(file, options, count);
  if (const std::size_t end = kFacetsBegin + kFacetBytes * count; bytes.size() > end) {
    sink.note(std::to_string(bytes.size() - end) + " bytes after the last facet passed over");
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (i % kCheckEvery == 0) {
      ctx.check();
      ctx.progress("import", static_cast<double>(i) / static_cast<double>(count));
    }
    std::array<float, 12> f{};  // normal, then three corners
    std::memcpy(f.data(), bytes.data() + kFacetsBegin + kFacetBytes * i, sizeof f);
    sink.add({f[3], f[4], f[5]}, {f[6], f[7], f[8]}, {f[9], f[10], f[11]}, i + 1);
  }
  return sink.finish("stl-binary", "facet");
}

/// Reads by keyword, not by line, and passes over words after one on its line: exporters add names there.
class AsciiStl {
 public:
  AsciiStl(const FileBytes& file, const ImportOptions& options, const run::Context& ctx)
      : file_(file), ctx_(ctx), scan_(file.bytes), sink_(file, options, file.bytes.size() / 250) {}

  RawModel read() {
    while (step(scan_.next())) {
    }
    if (in_facet_) fail("the file ends inside the facet begun on line " + std::to_string(facet_line_));
    if (solids_ > 1) sink_.note(std::to_string(solids_) + " solids in the file, taken as one part");
    return sink_.finish("stl-ascii", "line");
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    refuse(file_, "line " + std::to_string(scan_.line()) + ": " + what);
  }

  bool step(std::string_view word) {
    if (word.empty()) return false;
    if (same_word(word, "vertex")) {
      vertex();
    } else if (same_word(word, "facet")) {
      if (in_facet_) fail("a facet begins inside the facet of line " + std::to_string(facet_line_));
      begin_facet();
    } else if (same_word(word, "outer")) {
      if (!in_facet_) fail("'outer loop' outside a facet");
      if (!same_word(scan_.next(), "loop")) fail("'outer' without 'loop'");
    } else if (same_word(word, "endloop")) {
      if (!in_facet_) fail("'endloop' outside a facet");
      loose_line_ = scan_.line();
    } else if (same_word(word, "endfacet")) {
      end_facet();
    } else if (same_word(word, "solid") || same_word(word, "endsolid")) {
      if (in_facet_) fail(in_quotes(word) + " inside the facet begun on line " + std::to_string(facet_line_));
      if (same_word(word, "solid")) ++solids_;
      scan_.skip_line();
    } else if (scan_.line() != loose_line_) {
      fail("unexpected " + in_quotes(word));
    }
    return true;
  }

  void begin_facet() {
    in_facet_ = true;
    facet_line_ = scan_.line();
    corners_.clear();
    // The normal is not used, and often wrong; its numbers need not even be numbers.
    for (int k = 0; k < 4; ++k) scan_.next_on_line();
  }

  void vertex() {
    if (!in_facet_) fail("'vertex' outside a facet");
    Vec3 p;
    for (int k = 0; k < 3; ++k) {
      const std::string_view token = scan_.next();
      if (token.empty()) fail("the file ends inside a vertex");
      if (!parse_number(token, p[k])) fail(in_quotes(token) + " is not a coordinate");
    }
    if (corners_.size() >= kMaxCorners)
      fail("a facet of more than " + std::to_string(kMaxCorners) + " corners");
    corners_.push_back(p);
  }

  void end_facet() {
    if (!in_facet_) fail("'endfacet' without a facet");
    if (corners_.size() < 3) {
      fail("a facet of " + std::to_string(corners_.size()) + " corners; three are needed");
    }
    cut_.clear();
    triangulate(corners_, cut_);
    for (const Triangle& t : cut_) sink_.add(corners_[t[0]], corners_[t[1]], corners_[t[2]], facet_line_);
    in_facet_ = false;
    loose_line_ = scan_.line();
    if (++facets_ % kCheckEvery == 0) {
      ctx_.check();
      ctx_.progress("import", static_cast<double>(scan_.offset()) / static_cast<double>(file_.bytes.size()));
    }
  }

  const FileBytes& file_;
  const run::Context& ctx_;
  TokenScanner scan_;
  FacetSink sink_;
  std::vector<Vec3> corners_;
  std::vector<Triangle> cut_;
  bool in_facet_ = false;
  std::size_t facet_line_ = 0;
  std::size_t loose_line_ = 0;  ///< unknown words on this line are somebody's remarks
  std::size_t facets_ = 0;
  std::size_t solids_ = 0;
};

}  // namespace

bool is_stl(std::string_view bytes) { return length_fits_count(bytes) || is_ascii_stl(bytes); }

RawModel read_stl(const FileBytes& file, const ImportOptions& options, const run::Context& ctx) {
  if (length_fits_count(file.bytes)) return read_binary(file, options, ctx);
  if (is_ascii_stl(file.bytes)) return AsciiStl(file, options, ctx).read();
  const bool text = file.bytes.substr(0, kFacetsBegin).find('\0') == std::string_view::npos;
  if (file.bytes.size() < kFacetsBegin || (text && file.bytes.find('\0') == std::string_view::npos)) {
    refuse(file, "no STL: it begins with " + in_quotes(TokenScanner(file.bytes).next()) +
                     ", neither 'solid' with facets after it nor the 84 bytes a binary STL has at least");
  }
  return read_binary(file, options, ctx);
}

}  // namespace voidpath::mesh
