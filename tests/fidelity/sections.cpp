#include "tests/fidelity/sections.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace voidpath::fidelity {

namespace {

/// Digits of the cut heights, mm.
constexpr double kCutError = 1e-5;

/// Where the mesh's triangles pass the height. A corner exactly there counts as above.
std::vector<Edge> section(const mesh::TriangleMesh& mesh, const std::vector<std::uint32_t>& triangles,
                          double z) {
  std::vector<Edge> out;
  for (const std::uint32_t t : triangles) {
    const auto& corner = mesh.triangles[t];
    const mesh::Vec3* v[3] = {&mesh.vertices[corner[0]], &mesh.vertices[corner[1]],
                              &mesh.vertices[corner[2]]};
    // Counter-clockwise corners seen from outside: the edge that comes down lies left of the one that goes
    // up.
    std::optional<geom::Vec3> from, to;
    for (int k = 0; k < 3; ++k) {
      const mesh::Vec3 &a = *v[k], &b = *v[(k + 1) % 3];
      const bool above_a = a.z() >= z, above_b = b.z() >= z;
      if (above_a == above_b) continue;
      // The same two corners in the same order, whichever triangle asks: neighbours meet exactly.
      const bool swap = above_a;
      const mesh::Vec3 &low = swap ? b : a, &high = swap ? a : b;
      const double s = (z - low.z()) / (high.z() - low.z());
      const geom::Vec3 p = low + s * (high - low);
      (above_b ? to : from) = p;
    }
    if (from && to) out.push_back({from->x(), from->y(), to->x(), to->y()});
  }
  return out;
}

/// Sets what can be reached from the pixel by steps to the sides over pixels that are not set, and lists it.
std::vector<std::size_t> flood(Mask& mask, const Grid& grid, std::size_t from) {
  const auto nx = static_cast<std::size_t>(grid.nx);
  std::vector<std::size_t> reached{from};
  mask[from] = 1;
  const auto step = [&](std::size_t p) {
    if (mask[p] != 0) return;
    mask[p] = 1;
    reached.push_back(p);
  };
  for (std::size_t k = 0; k < reached.size(); ++k) {
    const std::size_t p = reached[k];
    if (p % nx > 0) step(p - 1);
    if (p % nx + 1 < nx) step(p + 1);
    if (p >= nx) step(p - nx);
    if (p + nx < mask.size()) step(p + nx);
  }
  return reached;
}

Mask inverse(Mask mask) {
  for (auto& m : mask) m ^= 1u;
  return mask;
}

/// A border lies half way between the middles of a pixel that is marked and of one that is not, as far as
/// they tell.
Mask resized(const Mask& mask, const Grid& grid, double by) {
  if (by == 0) return mask;
  const double between = 0.5 * grid.size;
  return by > 0 ? grown(mask, grid, by + between) : shrunk(mask, grid, between - by);
}

}  // namespace

Mask without_holes(const Mask& areas, const Grid& grid) {
  Mask outside = areas;
  // The border of a grid is empty plate.
  for (const std::size_t corner : {grid.at(0, 0), grid.at(grid.nx - 1, grid.ny - 1)})
    if (outside[corner] == 0) flood(outside, grid, corner);
  Mask out = areas;
  for (std::size_t p = 0; p < out.size(); ++p) out[p] |= static_cast<std::uint8_t>(outside[p] ^ 1u);
  return out;
}

Mask compensated(const Mask& areas, const Grid& grid, double outer, double hole) {
  if (outer == 0 && hole == 0) return areas;
  Mask out(areas.size(), 0);
  Mask done = inverse(areas);  // and what is not to be looked at
  const int margin = static_cast<int>(std::max({outer, hole, 0.0}) / grid.size) + 3;
  for (std::size_t p = 0; p < areas.size(); ++p) {
    if (done[p] != 0) continue;
    const Window w = around(flood(done, grid, p), grid, margin);
    const Mask body = without_holes(w.mask, w.grid);
    const Mask holes = without(body, w.mask);
    const Mask now =
        without(resized(body, w.grid, outer), count(holes) > 0 ? resized(holes, w.grid, hole) : Mask(holes));
    for (std::size_t q = 0; q < now.size(); ++q) out[w.whole(q, grid)] |= now[q];
  }
  return out;
}

Sections::Sections(const mesh::TriangleMesh& mesh, const Print& print, const Rules& rules, const Grid& grid)
    : mesh_(mesh), print_(print), rules_(rules), grid_(grid) {
  by_layer_.resize(print.layers.size());
  std::vector<double> cuts;
  for (const Layer& l : print.layers) cuts.push_back(cut(l));
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    double low = 1e300, high = -1e300;
    for (const auto v : mesh.triangles[t]) {
      low = std::min(low, mesh.vertices[v].z());
      high = std::max(high, mesh.vertices[v].z());
    }
    auto first = std::lower_bound(cuts.begin(), cuts.end(), low - kCutError);
    for (; first != cuts.end() && *first <= high + kCutError; ++first)
      by_layer_[static_cast<std::size_t>(first - cuts.begin())].push_back(t);
  }
}

/// Whether a corner lies in the height of the cut.
bool Sections::grazed(const std::vector<std::uint32_t>& triangles, double z) const {
  for (const std::uint32_t t : triangles)
    for (const auto v : mesh_.triangles[t])
      if (std::abs(mesh_.vertices[v].z() - z) <= kCutError) return true;
  return false;
}

/// Thin walls keep their width on the first layer: of what is no wider than foot and line together either is
/// right.
Mask Sections::asked_for(Mask cut, std::size_t i, bool least) const {
  const Layer& l = print_.layers[i];
  if (rules_.vase && i >= rules_.floor_layers) return without_holes(cut, grid_);
  cut = compensated(cut, grid_, rules_.outer_growth, rules_.hole_growth);
  if (rules_.foot <= 0 || l.top - l.height > rules_.ground + kCutError) return cut;
  Mask small = resized(cut, grid_, -rules_.foot);
  if (least) return small;
  // Borders lie half way between pixels' middles, and are known to half a pixel.
  const double thin = rules_.foot + 0.5 * rules_.line_width + grid_.size;
  const Mask wide = grown(shrunk(cut, grid_, thin), grid_, thin + grid_.size);
  const Mask narrow = without(cut, wide);
  if (count(narrow) == 0) return small;
  const Mask around = both(grown(narrow, grid_, 2 * rules_.foot), cut);
  for (std::size_t p = 0; p < small.size(); ++p) small[p] |= around[p];
  return small;
}

Section Sections::of(std::size_t i) const {
  if (i >= print_.layers.size()) return {Mask(grid_.count(), 0), Mask(grid_.count(), 0)};
  const double z = cut(print_.layers[i]);
  const std::vector<Edge> edges = section(mesh_, by_layer_[i], z - kCutError);
  Mask low = fill(edges, grid_);
  const bool plain = rules_.outer_growth == 0 && rules_.hole_growth == 0 && rules_.foot == 0 && !rules_.vase;
  Mask high = grazed(by_layer_[i], z) ? fill(section(mesh_, by_layer_[i], z + kCutError), grid_) : low;
  Mask most = low;
  for (std::size_t p = 0; p < most.size(); ++p) most[p] |= high[p];
  add_slivers(most, edges, grid_);
  if (low == high && plain) return {std::move(most), std::move(low)};
  return {asked_for(std::move(most), i, false), asked_for(both(low, high), i, true)};
}

}  // namespace voidpath::fidelity
