#pragma once

#include <array>
#include <string>
#include <vector>

namespace voidpath::toolpath {

enum class InfillPattern { rectilinear, grid, concentric, gyroid, lightning };
enum class SolidPattern { rectilinear, concentric, fermat };
/// Where lines of infill run: as infill_angle says, or whichever way prints soonest, one for the whole part
/// or one for each solid layer.
enum class InfillDirection { fixed, part, layer };
enum class SupportMode { none, plate, everywhere };
enum class SupportStyle { grid, tree };
enum class BrimType { outer, inner, both, ears };
enum class SeamPosition { nearest, aligned, rear };

/// What to build. Keys of the quality profile's `slice:` section; mm and degrees.
struct SliceSettings {
  double layer_height_mm = 0.2;
  double first_layer_height_mm = 0.2;
  bool adaptive_layers = false;  ///< heights between the two limits instead of layer_height_mm
  double min_layer_height_mm = 0.08;
  double max_layer_height_mm = 0.28;
  double adaptive_error_mm = 0.03;  ///< mean distance of a layer's steps from the surface, along its normal
  double line_width_mm = 0.45;
  double first_layer_line_width_mm = 0.45;
  int perimeters = 2;
  int top_layers = 5;
  int bottom_layers = 4;
  double top_thickness_mm = 0.7;  ///< as many layers more as this takes; with top_layers 0 there is no top
  double bottom_thickness_mm = 0.5;
  double infill_density = 0.15;  ///< 0 to 1
  InfillPattern infill_pattern = InfillPattern::rectilinear;
  int infill_every_layers =
      1;  ///< sparse infill of up to this many layers at once, no thicker than the nozzle
  InfillDirection infill_direction = InfillDirection::fixed;
  double infill_angle_deg = 45;
  SolidPattern solid_pattern = SolidPattern::rectilinear;
  SolidPattern top_pattern = SolidPattern::rectilinear;
  double infill_overlap = 0.25;  ///< of a line width, into the perimeters
  bool external_perimeters_first = false;
  double small_perimeter_length_mm = 40;  ///< loops up to this keep to speed.small_perimeter
  double bridge_flow = 1.0;               ///< of a bridge's strand, a round one of the nozzle's width
  SeamPosition seam = SeamPosition::nearest;
  SupportMode support = SupportMode::everywhere;
  SupportStyle support_style = SupportStyle::grid;
  double support_angle_deg = 45;  ///< from vertical: what leans out further is supported
  double support_density = 0.15;
  double support_xy_gap_mm = 0.5;
  double support_z_gap_mm = 0.2;
  int support_interface_layers = 2;
  double tree_tip_diameter_mm = 0.8;
  double tree_tip_distance_mm = 3.0;     ///< between neighbouring tips
  double tree_branch_diameter_mm = 5.0;  ///< no branch gets thicker
  double tree_branch_angle_deg = 40;     ///< from vertical: branches lean out no further
  int skirt_loops = 1;
  double skirt_gap_mm = 3.0;
  int skirt_layers = 1;
  BrimType brim_type = BrimType::outer;
  double brim_width_mm = 0;
  double brim_gap_mm = 0;           ///< between part and brim
  double brim_ear_angle_deg = 125;  ///< convex corners up to this get an ear
  int raft_layers = 0;              ///< in all; 0: no raft
  int raft_interface_layers = 2;    ///< the top ones of them, dense
  double raft_margin_mm = 3;        ///< beyond part and supports
  double raft_gap_mm = 0.15;        ///< air between raft and part
  double elephant_foot_mm = 0.0;    ///< first layer shrinks by this
  double xy_compensation_mm = 0;    ///< outer contours grow by this
  double hole_compensation_mm = 0;  ///< holes widen by this
  bool spiral_vase = false;         ///< above the bottom layers one wall that climbs all the way
  double resolution_mm = 0.0125;    ///< toolpaths are simplified to this
  double arc_tolerance_mm = 0.025;  ///< how far G2 and G3 may leave the toolpath, where the machine has them
  double min_infill_area_mm2 = 3;   ///< smaller sparse areas are filled solid
};

/// mm/s. Keys of `speed:`, each with the suffix _mm_s.
struct SpeedSettings {
  double perimeter = 45;
  double external_perimeter = 25;
  double infill = 80;
  double solid_infill = 80;
  double top_solid_infill = 40;
  double support = 50;
  double bridge = 30;
  double internal_bridge = 30;  ///< the first solid layer over sparse infill
  double small_perimeter = 25;
  /// Walls of whose bead a quarter, a half, three quarters at least hang over air; 0 doesn't slow them.
  double overhang_25 = 0;
  double overhang_50 = 20;
  double overhang_75 = 15;
  double gap_fill = 30;
  double travel = 180;
  double first_layer = 20;
};

/// mm/s². `print` 0 leaves the printer's own everywhere; any other 0 means as `print`. Keys of
/// `acceleration:`, suffix _mm_s2.
struct AccelerationSettings {
  double print = 0;
  double first_layer = 0;
  double travel = 0;
  double perimeter = 0;
  double external_perimeter = 0;
  double infill = 0;
  double solid_infill = 0;
  double top_solid_infill = 0;
  double bridge = 0;
  double support = 0;
};

struct RetractSettings {
  double length_mm = 0.8;
  double speed_mm_s = 35;
  double deretract_speed_mm_s = 35;
  double lift_mm = 0;
  double min_travel_mm = 1.5;  ///< shorter travels don't retract
  /// The nozzle moves on over what it just printed while it retracts, so that what oozes lands there.
  bool wipe = false;
  bool avoid_crossing_perimeters = true;  ///< a short detour inside the part is preferred to a retraction
};

struct CoolingSettings {
  bool enabled = true;
  double fan_min = 0.35;  ///< 0 to 1
  double fan_max = 1.0;
  double bridge_fan = 1.0;
  int fan_off_layers = 1;  ///< the first n layers print without fan
  int full_fan_at_layer =
      0;                     ///< between those and this layer (from 1) the fan gains speed evenly; 0: at once
  double slow_below_s = 10;  ///< layers that take less are slowed down...
  double min_speed_mm_s = 10;  ///< ...but not below this
  double full_fan_below_s = 30;
};

/// From the material's profile.
struct Filament {
  std::string name = "PLA";
  double diameter_mm = 1.75;
  double density_g_cm3 = 1.24;
  double flow = 1.0;              ///< extrusion multiplier
  double first_layer_flow = 1.0;  ///< and this one on top of it
  double nozzle_c = 210;
  double nozzle_first_layer_c = 215;
  double bed_c = 60;
  double bed_first_layer_c = 60;
  double max_flow_mm3_s = 15;  ///< speeds are lowered to keep to it; 0: no limit
  /// Advance of the extruder's pressure, s (Marlin's K, Klipper's pressure advance); 0 leaves the printer's.
  double linear_advance_s = 0;
};

/// From the printer's profile.
struct MachineShape {
  std::string name = "generic";
  std::array<double, 2> bed_mm = {220, 220};
  double height_mm = 250;
  bool origin_at_centre = false;  ///< (0,0) is the bed's middle, not its front left corner
  double nozzle_mm = 0.4;
  bool relative_e = true;
  bool arcs = false;      ///< the firmware runs G2 and G3
  bool progress = false;  ///< the firmware shows what M73 tells: percent done and minutes left
  /// Pictures of the part in the G-code's head, "WIDTHxHEIGHT" in pixels.
  std::vector<std::string> thumbnails = {"32x32", "400x300"};
  /// G-code before and after the print, with placeholders in braces such as {nozzle_first_layer_c};
  /// the list is in placeholders.h and config/README.md.
  std::string start_gcode;
  std::string end_gcode;
};

struct PrintSettings {
  SliceSettings slice;
  SpeedSettings speed;
  AccelerationSettings acceleration;
  RetractSettings retract;
  CoolingSettings cooling;
  Filament filament;
  MachineShape machine;
};

}  // namespace voidpath::toolpath
