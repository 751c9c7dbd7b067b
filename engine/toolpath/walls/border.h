#pragma once

#include "engine/geom/edge_grid.h"
#include "engine/geom/polygon.h"
#include "engine/toolpath/line_index.h"

#include <optional>
#include <vector>

namespace voidpath::toolpath {

/// The border of areas, for many questions how far it is.
class Border {
 public:
  explicit Border(const geom::Regions& areas);

  /// From a point, mm; some larger number where that is more than `limit_mm`.
  double distance_mm(const geom::Point& p, double limit_mm) const;
  /// Its nearest point; p itself where none is within the limit.
  geom::Point nearest(const geom::Point& p, double limit_mm) const;

 private:
  std::vector<geom::Edge> edges_;
  std::optional<LineIndex> index_;  ///< where there are many
};

}  // namespace voidpath::toolpath
