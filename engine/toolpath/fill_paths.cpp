#include "engine/toolpath/fill_paths.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/bead.h"

#include <utility>

namespace voidpath::toolpath {

Path make_path(Role role, geom::Polyline points, bool closed, double width, double height, double area) {
  Path path;
  path.role = role;
  path.points = std::move(points);
  path.closed = closed;
  path.width_mm = width;
  path.height_mm = height;
  path.area_mm2 = area;
  return path;
}

void add_fill(std::vector<Path>& out, Role role, FillLines&& fill, const BeadSize& bead,
              double tolerance_mm) {
  const double width = width_of_spacing_mm(fill.spacing_mm, bead.height_mm);
  const double area = fill.spacing_mm * bead.height_mm;
  for (auto& line : fill.lines) {
    if (fill.closed) line.push_back(line.front());
    if (line.size() > 2) line = geom::simplify(line, geom::from_mm(tolerance_mm));
    if (fill.closed) line.pop_back();
    if (line.size() > 1)
      out.push_back(make_path(role, std::move(line), fill.closed, width, bead.height_mm, area));
  }
}

}  // namespace voidpath::toolpath
