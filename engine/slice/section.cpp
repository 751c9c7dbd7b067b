#include "engine/slice/section.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace voidpath::slice {

namespace {

/// By corners above (bit k: corner k): the half-edge that runs down through the plane, and the one up.
constexpr std::array<std::uint8_t, 8> kDown = {0, 0, 1, 1, 2, 0, 2, 0};
constexpr std::array<std::uint8_t, 8> kUp = {0, 2, 0, 2, 1, 1, 0, 0};

void append(geom::Polyline& line, const geom::Point& p) {
  if (line.empty() || line.back() != p) line.push_back(p);
}

}  // namespace

Sections::Sections(const mesh::TriangleMesh& mesh, const std::vector<double>& heights_mm)
    : mesh_(mesh),
      heights_mm_(heights_mm),
      level_(mesh.vertices.size()),
      first_of_plane_(heights_mm.size() + 1) {
  assert(std::is_sorted(heights_mm.begin(), heights_mm.end()));
  for (std::size_t v = 0; v < level_.size(); ++v)
    level_[v] = static_cast<std::uint32_t>(
        std::upper_bound(heights_mm.begin(), heights_mm.end(), mesh.vertices[v].z()) - heights_mm.begin());

  auto lowest = [&](const mesh::Triangle& t) { return std::min({level_[t[0]], level_[t[1]], level_[t[2]]}); };
  auto highest = [&](const mesh::Triangle& t) {
    return std::max({level_[t[0]], level_[t[1]], level_[t[2]]});
  };
  for (const mesh::Triangle& t : mesh.triangles)
    if (lowest(t) != highest(t)) facets_.push_back(t);
  twins_ = edge_twins(facets_, mesh.vertices.size());

  for (const mesh::Triangle& t : facets_)
    for (std::size_t p = lowest(t); p < highest(t); ++p) ++first_of_plane_[p + 1];
  for (std::size_t p = 0; p < heights_mm.size(); ++p) first_of_plane_[p + 1] += first_of_plane_[p];
  cut_.resize(first_of_plane_.back());
  std::vector<std::size_t> next(first_of_plane_.begin(), first_of_plane_.end() - 1);
  for (std::size_t f = 0; f < facets_.size(); ++f)
    for (std::size_t p = lowest(facets_[f]); p < highest(facets_[f]); ++p)
      cut_[next[p]++] = static_cast<std::uint32_t>(f);
}

unsigned Sections::corners_above(std::uint32_t facet, std::size_t plane) const {
  const mesh::Triangle& t = facets_[facet];
  return static_cast<unsigned>(is_above(t[0], plane)) | static_cast<unsigned>(is_above(t[1], plane)) << 1 |
         static_cast<unsigned>(is_above(t[2], plane)) << 2;
}

/// Reckoned from the vertex of lower index, so that both facets of an edge agree to the last bit.
geom::Point Sections::crossing(HalfEdge edge, double z) const {
  const mesh::Triangle& t = facets_[edge / 3];
  const std::uint32_t v = t[edge % 3];
  const std::uint32_t w = t[(edge % 3 + 1) % 3];
  const geom::Vec3& a = mesh_.vertices[std::min(v, w)];
  const geom::Vec3& b = mesh_.vertices[std::max(v, w)];
  if (a.z() == z) return {geom::from_mm(a.x()), geom::from_mm(a.y())};
  if (b.z() == z) return {geom::from_mm(b.x()), geom::from_mm(b.y())};
  const double along = (z - a.z()) / (b.z() - a.z());
  return {geom::from_mm(a.x() + along * (b.x() - a.x())), geom::from_mm(a.y() + along * (b.y() - a.y()))};
}

Contours Sections::contours(std::size_t plane, Scratch& scratch) const {
  const double z = heights_mm_[plane];
  const auto mark = static_cast<std::uint32_t>(plane + 1);
  scratch.resize(facets_.size(), 0);
  Contours out;
  geom::Polyline line;
  for (std::size_t i = first_of_plane_[plane]; i < first_of_plane_[plane + 1]; ++i) {
    const std::uint32_t start = cut_[i];
    if (scratch[start] == mark) continue;
    line.clear();
    HalfEdge edge = 3 * start + kDown[corners_above(start, plane)];
    const HalfEdge first = edge;
    do {
      const std::uint32_t facet = edge / 3;
      scratch[facet] = mark;
      append(line, crossing(edge, z));
      const HalfEdge up = 3 * facet + kUp[corners_above(facet, plane)];
      edge = twins_[up];
      if (edge == kNoTwin) append(line, crossing(up, z));
    } while (edge != kNoTwin && edge != first);

    if (edge == first) {
      while (line.size() > 1 && line.back() == line.front()) line.pop_back();
      if (line.size() >= 3) out.closed.push_back(line);
      continue;
    }
    // Open: what comes before the facet the walk began in.
    std::reverse(line.begin(), line.end());
    for (HalfEdge up = twins_[first]; up != kNoTwin;) {
      const std::uint32_t facet = up / 3;
      scratch[facet] = mark;
      const HalfEdge down = 3 * facet + kDown[corners_above(facet, plane)];
      append(line, crossing(down, z));
      up = twins_[down];
    }
    std::reverse(line.begin(), line.end());
    if (line.size() >= 2) out.open.push_back(line);
  }
  return out;
}

}  // namespace voidpath::slice
