#pragma once

#include "engine/geom/polygon.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/walls/perimeters.h"

namespace voidpath::toolpath {

/// Fill lines and the bead they are meant for.
struct FillLines {
  geom::Polylines lines;
  bool closed = false;    ///< every line ends where it began, without repeating the point
  double spacing_mm = 0;  ///< the width of area one line stands for
};

/// Where the centre lines of fill may run, so that its beads overlap the walls as asked.
geom::Regions centre_line_area(const geom::Regions& area, const BeadSize& bead, double overlap);
/// How far beads of the filling reach beyond their area, in their widths: into the walls, and of a part
/// without walls not at all.
double fill_overlap(const SliceSettings& settings, const BeadSize& bead);

/// Lines side by side over one region of centre_line_area().
FillLines solid_fill(const geom::Region& domain, double angle_rad, const BeadSize& bead);

/// The settings' pattern at the settings' density, over the region; continues from layer to layer. Not for
/// lightning, which has to look at all layers.
FillLines sparse_fill(const geom::Region& domain, const SliceSettings& settings, double angle_rad,
                      const slice::LayerSpan& span, const BeadSize& bead);

/// The gyroid's cut at height z with the period given, over the box; lines run right through.
geom::Polylines gyroid_lines(const geom::Box& box, double z_mm, double period_mm);

}  // namespace voidpath::toolpath
