#pragma once

#include "engine/geom/polygon.h"
#include "engine/toolpath/emit/emit.h"
#include "engine/toolpath/settings.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace voidpath::toolpath {

/// G-code as text, with the state of the machine it drives: a word is written only when its value changes,
/// and the rounding of E is carried on, so that totals agree with the exact sums. Positions are whole
/// micrometres, E whole 10 nm.
class Writer {
 public:
  explicit Writer(const PrintSettings& settings);

  /// Units, positioning and extrusion mode.
  void begin();
  void comment(std::string_view text);
  void raw(std::string_view text);
  void layer_height(double z_mm);  ///< where the nozzle prints from now on
  void reset_e();                  ///< absolute E starts again from 0; nothing in relative mode
  void retract();
  /// Retracts while moving along `way`, which begins where the nozzle is: evenly over the whole of it if it
  /// takes the time the retraction does, otherwise what is too much at its beginning.
  void retract_along(const geom::Polyline& way);
  /// Of the way that takes as long as the retraction, mm.
  double wipe_length_mm() const;
  void unretract();
  void travel(const geom::Point& to);
  /// In a straight line; `volume_mm3` before the filament's flow factor.
  void extrude(const geom::Point& to, double volume_mm3, double speed_mm_s);
  /// The same along an arc about `centre`.
  void extrude_arc(const geom::Point& to, const geom::Point& centre, bool clockwise, double volume_mm3,
                   double speed_mm_s);
  /// The same while the nozzle rises to `z_mm`, where it prints from then on.
  void climb(const geom::Point& to, double z_mm, double volume_mm3, double speed_mm_s);
  void fan(double share);
  void acceleration(double mm_s2);
  void temperature(int code, double celsius);

  bool retracted() const { return retracted_; }
  const std::optional<geom::Point>& at() const { return at_; }
  std::string& text() { return text_; }
  EmitStats& stats() { return stats_; }

 private:
  void move_z(double z_mm);
  double filament_for(double volume_mm3);
  void put_retraction(double filament_mm);
  void lift();
  void put_xy(const geom::Point& to);
  void put_z(double z_mm);
  void put_e(double filament_mm);
  void put_feed(double mm_s);
  bool is_hardly_a_move(const geom::Point& to) const;
  void put_extrusion(const geom::Point& to, std::optional<double> z_mm, double volume_mm3, double speed_mm_s);

  const PrintSettings& settings_;
  double filament_mm2_;
  std::string text_;
  EmitStats stats_;
  std::optional<geom::Point> at_;     ///< as planned, nm
  std::optional<std::int64_t> x_um_;  ///< as written
  std::optional<std::int64_t> y_um_;
  std::optional<std::int64_t> z_um_;
  double z_mm_ = 0;
  double e_exact_mm_ = 0;       ///< since the last reset, in absolute mode; all of it otherwise
  std::int64_t e_written_ = 0;  ///< 1e-5 mm
  std::int64_t feed_ = -1;      ///< mm/min
  std::int64_t fan_ = -1;       ///< 0 to 255
  std::int64_t acceleration_ = -1;
  bool retracted_ = false;
};

}  // namespace voidpath::toolpath
