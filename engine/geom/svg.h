#pragma once

#include "engine/geom/polygon.h"

#include <string>
#include <string_view>

namespace voidpath::geom {

/// Drawing of layers for people: what a failing test attaches. Units in the picture are mm, y up.
class Svg {
 public:
  /// Filled half transparent with an outline. `colour` is any SVG colour.
  Svg& add(const Regions& regions, std::string_view colour = "steelblue");
  Svg& add(const Polylines& lines, std::string_view colour = "crimson", double width_mm = 0.05);
  Svg& add(const Point& point, std::string_view colour = "black", double radius_mm = 0.1);

  /// The whole document, framed by what was added.
  std::string str() const;

 private:
  void frame(const std::vector<Point>& points);

  std::string body_;
  Box frame_;
  bool is_empty_ = true;
};

}  // namespace voidpath::geom
