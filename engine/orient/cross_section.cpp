#include "engine/orient/cross_section.h"

#include <algorithm>
#include <utility>

namespace voidpath::orient {

namespace {

/// Facet lists are made for as many slices at once as keep below this many entries, so that thousands of
/// slices through a large mesh do not take memory in proportion.
constexpr std::size_t kBlockEntries = std::size_t{1} << 21;

}  // namespace

void CrossSections::prepare(const Solid& solid, const Projection& p, const std::vector<Slab>& slabs) {
  solid_ = &solid;
  p_ = &p;
  slabs_ = &slabs;
  rank_.resize(p.h.size());
  // A table by height tells where among the slices to look: nearly always there is one or none.
  const double steps_per_mm =
      p.h_max > p.h_min ? static_cast<double>(4 * slabs.size()) / (p.h_max - p.h_min) : 0;
  auto step_of = [&](double h) {
    return static_cast<std::size_t>(std::max(0.0, (h - p.h_min) * steps_per_mm));
  };
  start_.assign(4 * slabs.size() + 3, 0);
  for (const Slab& s : slabs) ++start_[std::min(step_of(s.middle_mm) + 1, start_.size() - 1)];
  for (std::size_t k = 1; k < start_.size(); ++k) start_[k] += start_[k - 1];
  for (std::size_t v = 0; v < p.h.size(); ++v) {
    const double h = p.h[v] + kHeightNoise;
    const std::size_t step = std::min(step_of(h), start_.size() - 2);
    std::size_t r = start_[step];
    std::size_t end = start_[step + 1];
    // Slices nearer to one another than a step are few but for the stricter rule of critical heights.
    while (r < end) {
      const std::size_t middle = (r + end) / 2;
      if (slabs[middle].middle_mm <= h) {
        r = middle + 1;
      } else {
        end = middle;
      }
    }
    rank_[v] = static_cast<Index>(r);
  }
  count_.assign(slabs.size() + 1, 0);
  crossings_.clear();
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    const auto& [a, b, c] = solid.triangles[t];
    const Index ra = rank_[a];
    const Index rb = rank_[b];
    const Index rc = rank_[c];
    const Index from = std::min(ra, std::min(rb, rc));
    const Index to = std::max(ra, std::max(rb, rc));
    if (from == to) continue;
    crossings_.push_back({static_cast<Index>(t), from, to});
    for (Index i = from; i < to; ++i) ++count_[i];
  }
  std::size_t sum = 0;
  for (std::size_t& n : count_) n = std::exchange(sum, sum + n);
  block_begin_ = block_end_ = 0;
  seen_.assign(solid.triangles.size(), 0);
  if (!solid.contacts.empty()) contour_of_.resize(solid.triangles.size());
}

void CrossSections::fill_block(std::size_t i) {
  block_begin_ = i;
  block_end_ = i + 1;
  while (block_end_ < slabs_->size() && count_[block_end_ + 1] - count_[i] <= kBlockEntries) ++block_end_;
  facets_.resize(count_[block_end_] - count_[i]);
  std::vector<std::size_t> next(count_.begin() + static_cast<std::ptrdiff_t>(i),
                                count_.begin() + static_cast<std::ptrdiff_t>(block_end_));
  for (const Crossing& c : crossings_)
    for (std::size_t s = std::max<std::size_t>(c.from, i); s < std::min<std::size_t>(c.to, block_end_); ++s)
      facets_[next[s - i]++ - count_[i]] = c.facet;
}

/// Notes the edge by which the slice leaves facet t; returns the facet beyond, kNone where the mesh is open.
Index CrossSections::leave(Index t, Index slice) {
  const auto& v = solid_->triangles[t];
  const bool up[3] = {rank_[v[0]] > slice, rank_[v[1]] > slice, rank_[v[2]] > slice};
  const std::size_t k = !up[0] && up[1] ? 0 : (!up[1] && up[2] ? 1 : 2);
  edges_.push_back({v[k], v[(k + 1) % 3]});
  return solid_->beside[t][k];
}

void CrossSections::trace(std::size_t i) {
  if (i < block_begin_ || i >= block_end_) fill_block(i);
  contours_.clear();
  edges_.clear();
  points_.clear();
  height_ = (*slabs_)[i].middle_mm;
  const auto slice = static_cast<Index>(i);
  const Index mark = slice + 1;
  mark_ = mark;
  const std::size_t base = count_[block_begin_];
  auto crossed = [&](Index t) {
    const auto& [a, b, c] = solid_->triangles[t];
    const int n = (rank_[a] > slice) + (rank_[b] > slice) + (rank_[c] > slice);
    return n == 1 || n == 2;
  };
  for (std::size_t k = count_[i]; k < count_[i + 1]; ++k) {
    const Index first = facets_[k - base];
    if (seen_[first] == mark) continue;
    Contour contour;
    contour.begin = edges_.size();
    contour.shell = solid_->shell_of[first];
    // In an open mesh the walk ends at the border; the line is then closed straight. (A start in the middle
    // of an open line leaves its first part to be found as a line of its own, closed likewise.)
    for (Index t = first; t != kNone && seen_[t] != mark && crossed(t); t = leave(t, slice)) {
      seen_[t] = mark;
      if (!contour_of_.empty()) contour_of_[t] = static_cast<Index>(contours_.size());
    }
    contour.end = edges_.size();
    contours_.push_back(contour);
  }
}

void CrossSections::place() {
  points_.resize(edges_.size());
  for (std::size_t k = 0; k < edges_.size(); ++k) {
    const auto [a, b] = edges_[k];
    const double t = std::min(1.0, (height_ - p_->h[a]) / (p_->h[b] - p_->h[a]));
    points_[k] = {p_->x[a] + t * (p_->x[b] - p_->x[a]), p_->y[a] + t * (p_->y[b] - p_->y[a])};
  }
  for (Contour& c : contours_) {
    double twice = 0;
    const Point2 o = points_[c.begin];
    for (std::size_t k = c.begin + 1; k + 1 < c.end; ++k) {
      const Point2 p = points_[k];
      const Point2 q = points_[k + 1];
      twice += (p.x - o.x) * (q.y - o.y) - (q.x - o.x) * (p.y - o.y);
    }
    c.area_mm2 = twice / 2;
  }
}

}  // namespace voidpath::orient
