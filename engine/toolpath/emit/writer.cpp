#include "engine/toolpath/emit/writer.h"

#include "engine/toolpath/emit/gcode_text.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace voidpath::toolpath {

namespace {

constexpr double kEUnitsPerMm = 1e5;
constexpr int kEDecimals = 5;
constexpr int kLengthDecimals = 3;
constexpr geom::Coord kNmPerUm = 1000;
/// Less is no move of its own, µm in x and in y: it would press out nothing or next to nothing.
constexpr std::int64_t kHardlyMovedUm = 4;
/// Wiping goes by a little slower than travelling, so that the retraction keeps up.
constexpr double kWipeSpeedShare = 0.8;

std::int64_t to_um(geom::Coord nm) {
  return nm >= 0 ? (nm + kNmPerUm / 2) / kNmPerUm : -((-nm + kNmPerUm / 2) / kNmPerUm);
}

}  // namespace

Writer::Writer(const PrintSettings& settings)
    : settings_(settings),
      filament_mm2_(std::numbers::pi / 4.0 * settings.filament.diameter_mm * settings.filament.diameter_mm) {}

void Writer::begin() {
  raw("G21");
  raw("G90");
  raw(settings_.machine.relative_e ? "M83" : "M82");
  raw("G92 E0");
}

void Writer::comment(std::string_view text) {
  text_ += ';';
  raw(text);
}

void Writer::raw(std::string_view text) {
  text_ += text;
  if (text.empty() || text.back() != '\n') text_ += '\n';
}

void Writer::put_xy(const geom::Point& to) {
  const std::int64_t x = to_um(to.x);
  const std::int64_t y = to_um(to.y);
  if (x_um_ != x) {
    text_ += " X";
    put_scaled(text_, x, kLengthDecimals);
    x_um_ = x;
  }
  if (y_um_ != y) {
    text_ += " Y";
    put_scaled(text_, y, kLengthDecimals);
    y_um_ = y;
  }
  at_ = to;
}

void Writer::put_e(double filament_mm) {
  e_exact_mm_ += filament_mm;
  const std::int64_t now = std::llround(e_exact_mm_ * kEUnitsPerMm);
  text_ += " E";
  put_scaled(text_, settings_.machine.relative_e ? now - e_written_ : now, kEDecimals);
  e_written_ = now;
}

void Writer::put_feed(double mm_s) {
  const std::int64_t feed = std::max<std::int64_t>(1, std::llround(mm_s * 60));
  if (feed == feed_) return;
  feed_ = feed;
  text_ += " F";
  put_scaled(text_, feed, 0);
}

void Writer::put_z(double z_mm) {
  z_mm_ = z_mm;
  const std::int64_t z = std::llround(z_mm * 1000);
  if (z_um_ == z) return;
  z_um_ = z;
  text_ += " Z";
  put_scaled(text_, z, kLengthDecimals);
}

void Writer::move_z(double z_mm) {
  const std::int64_t z = std::llround(z_mm * 1000);
  if (z_um_ == z) return;
  z_um_ = z;
  text_ += "G1 Z";
  put_scaled(text_, z, kLengthDecimals);
  put_feed(settings_.speed.travel);
  text_ += '\n';
}

void Writer::layer_height(double z_mm) {
  z_mm_ = z_mm;
  move_z(z_mm + (retracted_ ? settings_.retract.lift_mm : 0));
}

void Writer::reset_e() {
  if (settings_.machine.relative_e || e_written_ == 0) return;
  e_exact_mm_ -= static_cast<double>(e_written_) / kEUnitsPerMm;
  e_written_ = 0;
  raw("G92 E0");
}

void Writer::retract() {
  if (retracted_) return;
  retracted_ = true;
  if (settings_.retract.length_mm > 0) {
    put_retraction(settings_.retract.length_mm);
    ++stats_.retractions;
  }
  lift();
}

double Writer::wipe_length_mm() const {
  const RetractSettings& r = settings_.retract;
  if (r.length_mm <= 0 || r.speed_mm_s <= 0) return 0;
  return kWipeSpeedShare * settings_.speed.travel * r.length_mm / r.speed_mm_s;
}

void Writer::retract_along(const geom::Polyline& way) {
  const double whole = wipe_length_mm();
  const double length = std::min(geom::length(way) / geom::kNmPerMm, whole);
  if (retracted_ || !(length > 0)) return retract();
  retracted_ = true;
  ++stats_.retractions;
  comment("WIPE_START");
  const double per_mm = settings_.retract.length_mm / whole;
  if (length < whole) put_retraction(settings_.retract.length_mm - length * per_mm);
  for (std::size_t i = 1; i < way.size(); ++i) {
    const double e = -per_mm * geom::distance(way[i - 1], way[i]) / geom::kNmPerMm;
    if (x_um_ == to_um(way[i].x) && y_um_ == to_um(way[i].y)) {
      e_exact_mm_ += e;
      continue;
    }
    text_ += "G1";
    put_xy(way[i]);
    put_e(e);
    put_feed(kWipeSpeedShare * settings_.speed.travel);
    text_ += '\n';
  }
  comment("WIPE_END");
  lift();
}

void Writer::put_retraction(double filament_mm) {
  text_ += "G1";
  put_e(-filament_mm);
  put_feed(settings_.retract.speed_mm_s);
  text_ += '\n';
}

void Writer::lift() {
  if (settings_.retract.lift_mm > 0 && z_um_) move_z(z_mm_ + settings_.retract.lift_mm);
}

void Writer::unretract() {
  if (!retracted_) return;
  retracted_ = false;
  move_z(z_mm_);
  if (settings_.retract.length_mm > 0) {
    text_ += "G1";
    put_e(settings_.retract.length_mm);
    put_feed(settings_.retract.deretract_speed_mm_s);
    text_ += '\n';
  }
}

void Writer::travel(const geom::Point& to) {
  if (at_) stats_.travel_mm += geom::distance(*at_, to) / geom::kNmPerMm;
  if (x_um_ == to_um(to.x) && y_um_ == to_um(to.y)) {
    at_ = to;
    return;
  }
  text_ += "G1";
  put_xy(to);
  put_feed(settings_.speed.travel);
  text_ += '\n';
}

double Writer::filament_for(double volume_mm3) {
  const double volume = volume_mm3 * settings_.filament.flow;
  const double filament = volume / filament_mm2_;
  stats_.extruded_mm3 += volume;
  stats_.filament_mm += filament;
  return filament;
}

void Writer::extrude(const geom::Point& to, double volume_mm3, double speed_mm_s) {
  put_extrusion(to, {}, volume_mm3, speed_mm_s);
}

void Writer::climb(const geom::Point& to, double z_mm, double volume_mm3, double speed_mm_s) {
  put_extrusion(to, z_mm, volume_mm3, speed_mm_s);
}

bool Writer::is_hardly_a_move(const geom::Point& to) const {
  return x_um_ && y_um_ && std::abs(to_um(to.x) - *x_um_) <= kHardlyMovedUm &&
         std::abs(to_um(to.y) - *y_um_) <= kHardlyMovedUm;
}

void Writer::put_extrusion(const geom::Point& to, std::optional<double> z_mm, double volume_mm3,
                           double speed_mm_s) {
  const double filament = filament_for(volume_mm3);
  if (z_mm ? x_um_ == to_um(to.x) && y_um_ == to_um(to.y) : is_hardly_a_move(to)) {
    // Its material goes to the next one.
    e_exact_mm_ += filament;
    at_ = to;
    return;
  }
  text_ += "G1";
  put_xy(to);
  if (z_mm) put_z(*z_mm);
  put_e(filament);
  put_feed(speed_mm_s);
  text_ += '\n';
}

void Writer::extrude_arc(const geom::Point& to, const geom::Point& centre, bool clockwise, double volume_mm3,
                         double speed_mm_s) {
  if (!x_um_ || !y_um_) return extrude(to, volume_mm3, speed_mm_s);
  const std::int64_t i = to_um(centre.x) - *x_um_;
  const std::int64_t j = to_um(centre.y) - *y_um_;
  text_ += clockwise ? "G2" : "G3";
  put_xy(to);
  text_ += " I";
  put_scaled(text_, i, kLengthDecimals);
  text_ += " J";
  put_scaled(text_, j, kLengthDecimals);
  put_e(filament_for(volume_mm3));
  put_feed(speed_mm_s);
  text_ += '\n';
}

void Writer::fan(double share) {
  const std::int64_t value = std::clamp<std::int64_t>(std::llround(share * 255), 0, 255);
  if (value == fan_) return;
  fan_ = value;
  if (value == 0) return raw("M107");
  text_ += "M106 S";
  put_scaled(text_, value, 0);
  text_ += '\n';
}

void Writer::acceleration(double mm_s2) {
  const std::int64_t value = std::llround(mm_s2);
  if (value <= 0 || value == acceleration_) return;
  acceleration_ = value;
  text_ += "M204 S";
  put_scaled(text_, value, 0);
  text_ += '\n';
}

void Writer::temperature(int code, double celsius) {
  text_ += 'M';
  put_scaled(text_, code, 0);
  text_ += " S";
  put_scaled(text_, std::llround(celsius), 0);
  text_ += '\n';
}

}  // namespace voidpath::toolpath
