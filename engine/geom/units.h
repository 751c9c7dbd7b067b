#pragma once

#include <cmath>
#include <cstdint>

namespace voidpath::geom {

/// Length in the plane of a layer, in nanometres. Within ±1.07 m the polygon library stays in 64 bits.
using Coord = std::int64_t;

inline constexpr double kNmPerMm = 1e6;

inline Coord from_mm(double mm) { return static_cast<Coord>(std::llround(mm * kNmPerMm)); }
constexpr double to_mm(Coord nm) { return static_cast<double>(nm) / kNmPerMm; }
/// Area in nm² (as double) to mm².
constexpr double to_mm2(double nm2) { return nm2 / (kNmPerMm * kNmPerMm); }

}  // namespace voidpath::geom
