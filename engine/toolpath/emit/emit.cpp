#include "engine/toolpath/emit/emit.h"

#include "engine/run/parallel_for.h"
#include "engine/toolpath/emit/fit_arcs.h"
#include "engine/toolpath/emit/gcode_text.h"
#include "engine/toolpath/emit/pace.h"
#include "engine/toolpath/emit/placeholders.h"
#include "engine/toolpath/emit/writer.h"
#include "engine/toolpath/travel/travel.h"
#include "engine/toolpath/travel/wipe.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <ostream>
#include <vector>

namespace voidpath::toolpath {

namespace {

/// Text is handed to the stream in pieces of about this size, bytes: whoever reads along need not wait long.
constexpr std::size_t kFlushBytes = 64 * 1024;
/// Widths and heights that differ by less are the same to a reader of the comments, mm.
constexpr double kSameWidthMm = 5e-4;

bool mentions(std::string_view text, std::initializer_list<std::string_view> words) {
  for (const auto& w : words)
    if (text.find(w) != std::string_view::npos) return true;
  return false;
}

class Emitter {
 public:
  Emitter(const Plan& plan, const PrintSettings& settings, std::ostream& out, const run::Context& ctx,
          const motion::MachineLimits& limits)
      : plan_(plan), settings_(settings), limits_(limits), out_(out), ctx_(ctx), writer_(settings) {}

  EmitStats run(const std::string& header) {
    const Placeholders values = placeholders(plan_, settings_);
    // Both are expanded first: a mistake in the end G-code must not show after an hour of printing.
    const std::string start = expand(settings_.machine.start_gcode, values, "start G-code");
    const std::string end = expand(settings_.machine.end_gcode, values, "end G-code");
    write_header(header);
    if (!start.empty()) writer_.raw(start);
    writer_.begin();
    if (settings_.filament.linear_advance_s > 0)
      writer_.raw("M900 K" + decimal(settings_.filament.linear_advance_s, 4));
    writer_.fan(0);
    write_layers();
    if (writer_.at()) retract_towards(*writer_.at());
    writer_.fan(0);
    if (!end.empty()) writer_.raw(end);
    write_footer();
    flush();
    return writer_.stats();
  }

 private:
  void write_header(const std::string& header) {
    std::size_t from = 0;
    while (from < header.size()) {
      const std::size_t to = std::min(header.find('\n', from), header.size());
      writer_.raw("; " + header.substr(from, to - from));
      from = to + 1;
    }
  }

  void write_footer() {
    const EmitStats& s = writer_.stats();
    const double grams = s.extruded_mm3 * 1e-3 * settings_.filament.density_g_cm3;
    writer_.raw("; filament used [mm] = " + decimal(s.filament_mm, 2));
    writer_.raw("; filament used [cm3] = " + decimal(s.extruded_mm3 * 1e-3, 2));
    writer_.raw("; filament used [g] = " + decimal(grams, 2));
  }

  void flush() {
    out_.write(writer_.text().data(), static_cast<std::streamsize>(writer_.text().size()));
    writer_.text().clear();
  }

  /// After the first layer the filament's own temperatures hold, where the start G-code set any.
  void change_temperatures() {
    const Filament& f = settings_.filament;
    const std::string_view start = settings_.machine.start_gcode;
    if (f.nozzle_c != f.nozzle_first_layer_c && mentions(start, {"M104", "M109", "{nozzle_"}))
      writer_.temperature(104, f.nozzle_c);
    if (f.bed_c != f.bed_first_layer_c && mentions(start, {"M140", "M190", "{bed_c}", "{bed_first_layer_c}"}))
      writer_.temperature(140, f.bed_c);
  }

  void layer(std::size_t i) {
    const LayerPlan& layer = plan_.layers[i];
    ++writer_.stats().layers;
    writer_.comment("LAYER_CHANGE");
    writer_.comment("Z:" + decimal(layer.span.top_mm, 3));
    height_mm_ = layer.span.height_mm();
    writer_.comment("HEIGHT:" + decimal(height_mm_, 3));
    writer_.reset_e();
    if (i == 1) change_temperatures();
    pace_ = paces_[i];
    z_pending_ = true;
    has_type_ = false;
    for (std::size_t k = 0; k < layer.paths.size(); ++k)
      if (layer.paths[k].points.size() > 1) print(layer.paths[k], travels_[i][k], i);
  }

  /// Each as soon as the ways to its paths are found.
  void write_layers() {
    const std::size_t n = plan_.layers.size();
    std::vector<std::optional<geom::Point>> start(n + 1);
    for (std::size_t i = 0; i < n; ++i) {
      start[i + 1] = end_of_layer(plan_.layers[i]);
      if (!start[i + 1]) start[i + 1] = start[i];
    }
    travels_.resize(n);
    paces_.resize(n);
    const auto find_ways = [&](std::size_t i) {
      travels_[i] = plan_travels(plan_.layers[i], start[i], settings_);
      paces_[i] = pace_of_layer(plan_.layers[i], i, settings_, limits_, travels_[i]);
    };
    const auto write = [&](std::size_t i) {
      layer(i);
      if (writer_.text().size() > kFlushBytes) flush();
      ctx_.progress("write", static_cast<double>(i + 1) / static_cast<double>(n));
    };
    run::parallel_before(ctx_, n, find_ways, write);
  }

  void print(const Path& path, const Travel& travel, std::size_t i) {
    go_to(path, travel, plan_.layers[i]);
    describe(path);
    writer_.acceleration(path_acceleration_mm_s2(path, i, settings_));
    writer_.fan(keeps_speed(path.role) ? pace_.bridge_fan : pace_.fan);
    const double speed = pace_.apply(path_speed_mm_s(path, i, settings_), path.role);
    writer_.unretract();
    const bool arcs = settings_.machine.arcs && settings_.slice.arc_tolerance_mm > 0;
    if (path.rise) {
      climb(path, speed);
    } else if (arcs && path.points.size() > 3) {
      extrude_curved(path, speed);
    } else {
      for (std::size_t k = 1; k < path.points.size(); ++k)
        extrude(path, path.points[k - 1], path.points[k], speed);
      if (path.closed) extrude(path, path.points.back(), path.points.front(), speed);
    }
    last_ = &path;
  }

  /// Each segment has the share of the bead that its middle has.
  void climb(const Path& path, double speed) {
    const Rise& rise = *path.rise;
    const double whole = geom::length(path.points);
    double along = 0;
    for (std::size_t k = 1; k < path.points.size(); ++k) {
      const double length = geom::distance(path.points[k - 1], path.points[k]);
      const double middle = (along + 0.5 * length) / whole;
      along += length;
      const double z = rise.from_mm + (rise.to_mm - rise.from_mm) * along / whole;
      const double share = rise.share_from + (rise.share_to - rise.share_from) * middle;
      writer_.climb(path.points[k], z, length / geom::kNmPerMm * path.area_mm2 * share, speed);
    }
  }

  void extrude(const Path& path, const geom::Point& from, const geom::Point& to, double speed) {
    writer_.extrude(to, geom::distance(from, to) / geom::kNmPerMm * path.area_mm2, speed);
  }

  /// With arcs where they fit. An arc gets the material of the pieces it stands for.
  void extrude_curved(const Path& path, double speed) {
    geom::Polyline line = path.points;
    if (path.closed) line.push_back(line.front());
    std::size_t k = 0;
    for (const Stroke& stroke : fit_arcs(line, settings_.slice.arc_tolerance_mm)) {
      double length = 0;
      for (; k < stroke.last; ++k) length += geom::distance(line[k], line[k + 1]);
      const double volume = length / geom::kNmPerMm * path.area_mm2;
      if (stroke.turn == 0)
        writer_.extrude(stroke.to, volume, speed);
      else
        writer_.extrude_arc(stroke.to, stroke.centre, stroke.turn < 0, volume, speed);
    }
  }

  void describe(const Path& path) {
    if (!has_type_ || role_ != path.role) {
      has_type_ = true;
      role_ = path.role;
      writer_.comment("TYPE:" + std::string(type_name(path.role)));
    }
    if (std::abs(width_mm_ - path.width_mm) >= kSameWidthMm) {
      width_mm_ = path.width_mm;
      writer_.comment("WIDTH:" + decimal(path.width_mm, 3));
    }
    if (std::abs(height_mm_ - path.height_mm) >= kSameWidthMm) {
      height_mm_ = path.height_mm;
      writer_.comment("HEIGHT:" + decimal(path.height_mm, 3));
    }
  }

  void retract_towards(const geom::Point& to) {
    if (settings_.retract.wipe && last_ != nullptr)
      writer_.retract_along(wipe_way(*last_, to, writer_.wipe_length_mm()));
    else
      writer_.retract();
  }

  void go_to(const Path& path, const Travel& travel, const LayerPlan& layer) {
    const geom::Point& to = path.points.front();
    if (travel.retract && writer_.at()) retract_towards(to);
    if (path.rise)
      writer_.layer_height(path.rise->from_mm);
    else if (z_pending_)
      writer_.layer_height(layer.span.top_mm);
    z_pending_ = false;
    if (writer_.at() && *writer_.at() == to) return;
    if (settings_.acceleration.travel > 0 && settings_.acceleration.print > 0)
      writer_.acceleration(settings_.acceleration.travel);
    for (const geom::Point& p : travel.via) writer_.travel(p);
    writer_.travel(to);
  }

  const Plan& plan_;
  const PrintSettings& settings_;
  const motion::MachineLimits& limits_;
  std::ostream& out_;
  const run::Context& ctx_;
  Writer writer_;
  std::vector<std::vector<Travel>> travels_;  ///< by layer and path
  std::vector<Pace> paces_;                   ///< by layer
  Pace pace_;
  const Path* last_ = nullptr;  ///< printed
  Role role_ = Role::infill;
  bool has_type_ = false;
  bool z_pending_ = true;
  double width_mm_ = 0;
  double height_mm_ = 0;
};

}  // namespace

EmitStats emit(const Plan& plan, const PrintSettings& settings, const std::string& header, std::ostream& out,
               const motion::MachineLimits& limits, const run::Context& ctx) {
  return Emitter(plan, settings, out, ctx, limits).run(header);
}

}  // namespace voidpath::toolpath
