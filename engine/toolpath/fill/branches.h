#pragma once

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon.h"
#include "engine/toolpath/line_index.h"

#include <cstdint>
#include <vector>

namespace voidpath::toolpath {

/// Trees of straight lines in an area, each rooted at its border. One layer's lightning.
class Branches {
 public:
  static constexpr std::uint32_t kNone = 0xffffffff;

  struct Node {
    geom::Point at;
    std::uint32_t parent = kNone;  ///< towards the root; an earlier node once sorted
  };

  bool empty() const { return nodes_.empty(); }
  const std::vector<Node>& nodes() const { return nodes_; }

  /// Every branch becomes shorter by `by` nm from its tip, and nodes between two others move by up to as much
  /// towards the straight line.
  void shrink(double by);
  /// Leaves what lies in the area: branches that leave it are cut and end, or are rooted, where they do.
  void clip(const geom::AreaGrid& area);
  /// Roots that the border has left behind are joined to it: by moving those no further than `near` nm away.
  void ground(const LineIndex& border, double near);
  /// A line from the point to the border or to a branch, whichever is nearer, the branch's own way to its
  /// root counted in part: long ways last through many layers. The point becomes a tip. `lines` indexes the
  /// branches as index() does.
  void connect(const geom::Point& tip, const LineIndex& border, LineIndex& lines,
               std::vector<std::uint32_t>& line_nodes);
  /// Indexes the branches' lines, and tells the lower node of each.
  void index(LineIndex& lines, std::vector<std::uint32_t>& line_nodes) const;

  /// Restores the order, parents first, after ground() and connect().
  void sort();

  /// As few lines as there are tips.
  geom::Polylines lines() const;

 private:
  std::vector<std::vector<std::uint32_t>> children() const;

  std::vector<Node> nodes_;
};

}  // namespace voidpath::toolpath
