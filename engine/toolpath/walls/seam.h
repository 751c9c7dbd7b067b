#pragma once

#include "engine/geom/polygon.h"
#include "engine/toolpath/settings.h"

#include <cstddef>
#include <vector>

namespace voidpath::toolpath {

/// Chooses where closed loops begin and end, layer after layer.
class SeamChooser {
 public:
  explicit SeamChooser(SeamPosition position) : position_(position) {}

  void begin_layer();
  /// Index of the vertex an external loop starts at; `at` is where the nozzle comes from.
  std::size_t choose(const geom::Ring& loop, const geom::Point& at);

 private:
  SeamPosition position_;
  std::vector<geom::Point> previous_;  ///< seams of the layer below
  std::vector<geom::Point> current_;
};

/// Index of the ring's vertex nearest to the point.
std::size_t nearest_vertex(const geom::Ring& ring, const geom::Point& p);
/// The ring turned so that it begins with this vertex.
geom::Ring start_at(const geom::Ring& ring, std::size_t vertex);

}  // namespace voidpath::toolpath
