#include "engine/report/raster.h"

#include "engine/report/markup.h"
#include "engine/report/scan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace voidpath::report {

namespace {

using geom::Vec3;

constexpr float kFar = std::numeric_limits<float>::infinity();
/// Facets that meet at more than this get an edge drawn between them. cos of 32°
constexpr double kSharp_cos = 0.848;
/// A step in depth is an edge when it is this much of the part's size more than the surface's slope explains.
constexpr double kStepShare = 0.006;

class Painter {
 public:
  Painter(const Standing& part, const View& view, const Window& window)
      : part_(part), view_(view), w_(window), size_(part.box.size().norm()) {
    const auto pixels = static_cast<std::size_t>(w_.width) * static_cast<std::size_t>(w_.height);
    depth_.assign(pixels, kFar);
    facet_.assign(pixels, kNoFacet);
    support_depth_.assign(pixels, kFar);
    support_shade_.assign(pixels, 0);
    shadow_.assign(pixels, 0);
  }

  Painting paint() {
    draw_part();
    draw_support();
    Painting out{w_.width, w_.height, {}};
    out.pixels.reserve(depth_.size());
    for (int j = 0; j < w_.height; ++j)
      for (int i = 0; i < w_.width; ++i) out.pixels.push_back(pixel(i, j));
    return out;
  }

 private:
  static constexpr std::uint32_t kNoFacet = ~std::uint32_t{0};

  std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(w_.width) + static_cast<std::size_t>(i);
  }
  Corner place(const Vec3& p) const {
    const Vec3 s = view_.see(p);
    return {(s.x() - w_.left_mm) * w_.px_per_mm, (w_.top_mm - s.y()) * w_.px_per_mm, s.z()};
  }

  void draw_part() {
    const auto& m = part_.mesh;
    overhang_ = find_overhangs(m, part_.overhang_deg);
    normals_.reserve(m.triangles.size());
    std::vector<Corner> placed, flat;
    placed.reserve(m.vertices.size());
    flat.reserve(m.vertices.size());
    for (const Vec3& v : m.vertices) {
      placed.push_back(place(v));
      flat.push_back(place({v.x(), v.y(), 0}));
    }
    for (std::size_t t = 0; t < m.triangles.size(); ++t) {
      const auto& [a, b, c] = m.triangles[t];
      Vec3 n = (m.vertices[b] - m.vertices[a]).cross(m.vertices[c] - m.vertices[a]);
      const double length = n.norm();
      n = length > 0 ? Vec3(n / length) : Vec3::Zero();
      // Seen from inside, through a hole: shaded as the wall it is.
      normals_.push_back(view_.see(n));
      if (normals_.back().z() > 0) normals_.back() = -normals_.back();
      scan({placed[a], placed[b], placed[c]}, w_.width, w_.height, [&](int i, int j, double depth) {
        const std::size_t k = index(i, j);
        if (static_cast<float>(depth) >= depth_[k]) return;
        depth_[k] = static_cast<float>(depth);
        facet_[k] = static_cast<std::uint32_t>(t);
      });
      scan({flat[a], flat[b], flat[c]}, w_.width, w_.height,
           [&](int i, int j, double) { shadow_[index(i, j)] = 1; });
    }
  }

  /// Walls of the columns under overhangs, where no neighbour hides them; only the two sides that are seen.
  void draw_support() {
    const VoidColumns& v = part_.columns;
    for (int j = 0; j < v.depth(); ++j) {
      for (int i = 0; i < v.width(); ++i) {
        for (const Gap& g : v.gaps(i, j)) {
          if (!g.overhang) continue;
          const double x1 = v.x(i + 1);
          draw_wall(g, v.gaps(i, j - 1), {v.x(i), v.y(j), 0}, {x1, v.y(j), 0}, 1);
          draw_wall(g, v.gaps(i + 1, j), {x1, v.y(j), 0}, {x1, v.y(j + 1), 0}, 0);
        }
      }
    }
  }

  void draw_wall(const Gap& gap, VoidColumns::Range beside, Vec3 a, Vec3 b, std::uint8_t shade) {
    double from = static_cast<double>(gap.bottom);
    const double end = static_cast<double>(gap.top);
    const auto piece = [&](double z0, double z1) {
      if (!(z1 > z0)) return;
      const std::array<Vec3, 4> p{Vec3(a.x(), a.y(), z0), Vec3(b.x(), b.y(), z0), Vec3(b.x(), b.y(), z1),
                                  Vec3(a.x(), a.y(), z1)};
      const std::array<Corner, 4> c{place(p[0]), place(p[1]), place(p[2]), place(p[3])};
      const auto at = [&](int i, int j, double depth) {
        const std::size_t k = index(i, j);
        if (static_cast<float>(depth) >= support_depth_[k]) return;
        support_depth_[k] = static_cast<float>(depth);
        support_shade_[k] = shade;
      };
      scan({c[0], c[1], c[2]}, w_.width, w_.height, at);
      scan({c[0], c[2], c[3]}, w_.width, w_.height, at);
    };
    for (const Gap& other : beside) {
      if (!other.overhang || static_cast<double>(other.top) <= from) continue;
      if (static_cast<double>(other.bottom) >= end) break;
      piece(from, static_cast<double>(other.bottom));
      from = static_cast<double>(other.top);
    }
    piece(from, end);
  }

  bool is_edge(int i, int j) const {
    const std::size_t k = index(i, j);
    for (const auto& [di, dj] : {std::pair(1, 0), std::pair(0, 1), std::pair(-1, 0), std::pair(0, -1)}) {
      if (i + di < 0 || j + dj < 0 || i + di >= w_.width || j + dj >= w_.height) return true;
      const std::size_t o = index(i + di, j + dj);
      if (facet_[o] == kNoFacet) return true;
      if (facet_[o] == facet_[k]) continue;
      const Vec3& n = normals_[facet_[k]];
      // Edges are drawn once, on the nearer side or the upper left one.
      const double step = static_cast<double>(depth_[o]) - static_cast<double>(depth_[k]);
      const double slope =
          (std::abs(n.x()) + std::abs(n.y())) / std::max(0.05, std::abs(n.z())) / w_.px_per_mm;
      if (step > kStepShare * size_ + 2 * slope) return true;
      if (di + dj > 0 && std::abs(step) <= kStepShare * size_ + 2 * slope &&
          n.dot(normals_[facet_[o]]) < kSharp_cos)
        return true;
    }
    return false;
  }

  /// 0 to 1: a lamp at the upper left behind the eye, and light from above.
  static double light(const Vec3& n) {
    static const Vec3 lamp = Vec3(-0.5, 0.62, -0.75).normalized();
    return std::clamp(0.16 + 0.62 * std::max(0.0, n.dot(lamp)) + 0.22 * (0.5 + 0.5 * n.y()), 0.0, 1.0);
  }

  std::uint8_t pixel(int i, int j) const {
    const auto coded = [](Ink ink, double shade) {
      const int step = std::clamp(static_cast<int>(shade * kShades), 0, kShades - 1);
      return static_cast<std::uint8_t>(static_cast<int>(ink) * kShades + step);
    };
    const std::size_t k = index(i, j);
    // Support that grazes the part it stands on does not veil it.
    const bool veiled = support_depth_[k] < depth_[k] - static_cast<float>(0.002 * size_);
    if (facet_[k] == kNoFacet) {
      if (support_depth_[k] != kFar) return coded(Ink::support, support_shade_[k] != 0 ? 0.99 : 0.5);
      return shadow_[k] != 0 ? coded(Ink::shadow, 0) : coded(Ink::nothing, 0);
    }
    double shade = light(normals_[facet_[k]]);
    if (is_edge(i, j)) shade *= 0.45;
    if (overhang_[facet_[k]]) return coded(Ink::overhang, shade);
    return coded(veiled ? Ink::part_behind_support : Ink::part, shade);
  }

  const Standing& part_;
  const View& view_;
  const Window& w_;
  double size_;
  std::vector<bool> overhang_;
  std::vector<Vec3> normals_;  ///< in the view, towards the eye
  std::vector<float> depth_, support_depth_;
  std::vector<std::uint32_t> facet_;
  std::vector<std::uint8_t> support_shade_, shadow_;
};

std::string colour_of(Ink ink, int shade) {
  const double s = (shade + 0.5) / kShades;
  const Rgb support{245, 159, 0};
  const Rgb part =
      s < 0.5 ? mix({24, 38, 58}, {92, 128, 168}, 2 * s) : mix({92, 128, 168}, {233, 241, 250}, 2 * s - 1);
  switch (ink) {
    case Ink::nothing:
      break;
    case Ink::part:
      return hex(part);
    case Ink::overhang:
      return hex(mix({96, 24, 12}, {255, 150, 120}, s));
    case Ink::part_behind_support:
      return hex(mix(part, support, 0.55));
    case Ink::support:
      return hex(mix(support, {255, 224, 150}, s));
    case Ink::shadow:
      return "#000000";
  }
  return "none";
}

/// Strokes along the rows where `wanted` holds, as path data with relative moves.
template <class Wanted>
void add_runs(const Painting& p, Wanted&& wanted, std::string& out) {
  int pen_x = 0;
  int pen_y = 0;
  for (int j = 0; j < p.height; ++j) {
    for (int i = 0; i < p.width; ++i) {
      if (!wanted(p.at(i, j))) continue;
      const int begin = i;
      while (i < p.width && wanted(p.at(i, j))) ++i;
      out += 'm' + std::to_string(begin - pen_x) + ' ' + std::to_string(j - pen_y) + 'h' +
             std::to_string(i - begin);
      pen_x = i;
      pen_y = j;
    }
  }
}

}  // namespace

Painting paint(const Standing& part, const View& view, const Window& window) {
  return Painter(part, view, window).paint();
}

std::string rows_of(const Painting& painting) {
  const auto ink_of = [](std::uint8_t code) { return static_cast<Ink>(code / kShades); };
  std::array<std::string, kInks * kShades> paths;
  std::array<std::pair<int, int>, kInks * kShades> pens{};
  for (int j = 0; j < painting.height; ++j) {
    for (int i = 0; i < painting.width;) {
      const std::uint8_t code = painting.at(i, j);
      const int begin = i;
      while (i < painting.width && painting.at(i, j) == code) ++i;
      if (ink_of(code) == Ink::nothing) continue;
      auto& [x, y] = pens[code];
      paths[code] +=
          'm' + std::to_string(begin - x) + ' ' + std::to_string(j - y) + 'h' + std::to_string(i - begin);
      x = i;
      y = j;
    }
  }
  std::string out;
  const auto add = [&](const std::string& data, const std::string& colour, const char* more) {
    if (data.empty()) return;
    out += "<path stroke=\"" + colour + "\"" + more + " d=\"" + data + "\"/>\n";
  };
  add(paths[static_cast<std::size_t>(Ink::shadow) * kShades], "#000",
      " stroke-opacity=\".13\" stroke-width=\"1\"");
  // Under the seams between strokes, which a screen's own pixels would let the page shine through.
  std::string underlay;
  add_runs(
      painting,
      [&](std::uint8_t c) {
        return ink_of(c) != Ink::nothing && ink_of(c) != Ink::shadow && ink_of(c) != Ink::support;
      },
      underlay);
  add(underlay, colour_of(Ink::part, kShades / 2), "");
  for (std::size_t code = 0; code < paths.size(); ++code) {
    const Ink ink = ink_of(static_cast<std::uint8_t>(code));
    if (ink == Ink::shadow) continue;
    add(paths[code], colour_of(ink, static_cast<int>(code % kShades)),
        ink == Ink::support ? " stroke-opacity=\".75\" stroke-width=\"1\"" : "");
  }
  return out;
}

}  // namespace voidpath::report
