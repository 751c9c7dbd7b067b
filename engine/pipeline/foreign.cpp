#include "engine/pipeline/foreign.h"

#include "engine/gcode/walk.h"
#include "engine/orient/words.h"

#include <numbers>
#include <stdexcept>

namespace voidpath::pipeline {

namespace {

/// How far an outer wall's centre line may lie outside of the part: slicers compensate and merge, by less
/// than a line; a part that was moved or turned is off by more.
constexpr double kOutOfPlace_mm = 1.0;
/// Rounded coordinates of a part that fits exactly.
constexpr double kRounding_mm = 0.05;

std::string range_text(const char* axis, double from, double to) {
  return std::string(axis) + " " + orient::number(from, 2) + " to " + orient::number(to, 2) + " mm";
}

gcode::Extents box_of(const PlacedPart& part) {
  const mesh::Bounds b = mesh::bounds(part.mesh);
  gcode::Extents box;
  box.add({b.min.x() + part.centre_mm[0], b.min.y() + part.centre_mm[1], b.min.z()});
  box.add({b.max.x() + part.centre_mm[0], b.max.y() + part.centre_mm[1], b.max.z()});
  return box;
}

gcode::Extents machine_box(const toolpath::MachineShape& m) {
  gcode::Extents box;
  const double x0 = m.origin_at_centre ? -m.bed_mm[0] / 2 : 0;
  const double y0 = m.origin_at_centre ? -m.bed_mm[1] / 2 : 0;
  box.add({x0, y0, 0});
  box.add({x0 + m.bed_mm[0], y0 + m.bed_mm[1], m.height_mm});
  return box;
}

}  // namespace

void check_foreign(const std::filesystem::path& gcode, const PlacedPart& part,
                   const gcode::Estimate& estimate) {
  const gcode::PrintedExtents printed = gcode::printed_extents(gcode);
  if (!printed.all.any || estimate.filament_mm <= 0)
    throw std::runtime_error("the slicer's G-code prints nothing");
  const char* const axes[] = {"x", "y", "z"};
  const gcode::Extents machine = machine_box(part.print.machine);
  for (std::size_t a = 0; a < 3; ++a) {
    if (printed.all.min[a] >= machine.min[a] - kRounding_mm &&
        printed.all.max[a] <= machine.max[a] + kRounding_mm)
      continue;
    throw std::runtime_error(
        "the slicer's G-code prints at " + range_text(axes[a], printed.all.min[a], printed.all.max[a]) +
        ", but the printer reaches " + range_text(axes[a], machine.min[a], machine.max[a]));
  }
  if (!printed.outer_walls.any) return;
  const gcode::Extents box = box_of(part);
  for (std::size_t a = 0; a < 2; ++a) {
    if (printed.outer_walls.min[a] >= box.min[a] - kOutOfPlace_mm &&
        printed.outer_walls.max[a] <= box.max[a] + kOutOfPlace_mm)
      continue;
    throw std::runtime_error("the slicer put the part elsewhere: its walls are at " +
                             range_text(axes[a], printed.outer_walls.min[a], printed.outer_walls.max[a]) +
                             " and should be within " + range_text(axes[a], box.min[a], box.max[a]) +
                             "; does its profile turn or move parts, or know another bed?");
  }
}

toolpath::EmitStats foreign_stats(const gcode::Estimate& estimate, const toolpath::PrintSettings& print) {
  const double radius = print.filament.diameter_mm / 2;
  toolpath::EmitStats stats;
  stats.layers = estimate.layers.size();
  stats.filament_mm = estimate.filament_mm;
  stats.extruded_mm3 = estimate.filament_mm * std::numbers::pi * radius * radius;
  stats.travel_mm = estimate.travel_mm;
  stats.retractions = estimate.retractions;
  return stats;
}

}  // namespace voidpath::pipeline
