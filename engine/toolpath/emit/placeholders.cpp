#include "engine/toolpath/emit/placeholders.h"

#include "engine/toolpath/emit/gcode_text.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace voidpath::toolpath {

namespace {

struct Extent {
  double min[2] = {std::numeric_limits<double>::max(), std::numeric_limits<double>::max()};
  double max[2] = {std::numeric_limits<double>::lowest(), std::numeric_limits<double>::lowest()};

  void add(const LayerPlan& layer) {
    for (const Path& path : layer.paths)
      for (const geom::Point& p : path.points) {
        const double at[2] = {geom::to_mm(p.x), geom::to_mm(p.y)};
        for (int a = 0; a < 2; ++a) {
          min[a] = std::min(min[a], at[a] - path.width_mm / 2);
          max[a] = std::max(max[a], at[a] + path.width_mm / 2);
        }
      }
  }
  void close() {
    for (int a = 0; a < 2; ++a)
      if (min[a] > max[a]) min[a] = max[a] = 0;
  }
};

void put_extent(Placeholders& out, const Extent& e, const std::string& prefix) {
  const char* axis[2] = {"x", "y"};
  for (int a = 0; a < 2; ++a) {
    out[prefix + "min_" + axis[a]] = decimal(e.min[a], 3);
    out[prefix + "max_" + axis[a]] = decimal(e.max[a], 3);
  }
}

bool is_name(std::string_view s) {
  return !s.empty() && std::all_of(s.begin(), s.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
}

}  // namespace

Placeholders placeholders(const Plan& plan, const PrintSettings& settings) {
  Extent first;
  Extent all;
  for (std::size_t i = 0; i < plan.layers.size(); ++i) {
    if (i == 0) first.add(plan.layers[i]);
    all.add(plan.layers[i]);
  }
  first.close();
  all.close();

  const Filament& f = settings.filament;
  const MachineShape& m = settings.machine;
  const SliceSettings& s = settings.slice;
  Placeholders out{
      {"nozzle_c", decimal(f.nozzle_c, 1)},
      {"nozzle_first_layer_c", decimal(f.nozzle_first_layer_c, 1)},
      {"bed_c", decimal(f.bed_c, 1)},
      {"bed_first_layer_c", decimal(f.bed_first_layer_c, 1)},
      {"filament", f.name},
      {"filament_diameter", decimal(f.diameter_mm, 3)},
      {"printer", m.name},
      {"nozzle_mm", decimal(m.nozzle_mm, 3)},
      {"bed_x", decimal(m.bed_mm[0], 3)},
      {"bed_y", decimal(m.bed_mm[1], 3)},
      {"height", decimal(m.height_mm, 3)},
      {"layer_height", decimal(s.layer_height_mm, 3)},
      {"first_layer_height", decimal(s.first_layer_height_mm, 3)},
      {"line_width", decimal(s.line_width_mm, 3)},
      {"perimeters", decimal(s.perimeters, 0)},
      {"infill_density", decimal(s.infill_density, 3)},
      {"travel_speed", decimal(settings.speed.travel, 3)},
      {"first_layer_speed", decimal(settings.speed.first_layer, 3)},
      {"travel_feed", decimal(settings.speed.travel * 60, 0)},
      {"first_layer_feed", decimal(settings.speed.first_layer * 60, 0)},
      {"retract_length", decimal(settings.retract.length_mm, 3)},
      {"retract_speed", decimal(settings.retract.speed_mm_s, 3)},
      {"retract_feed", decimal(settings.retract.speed_mm_s * 60, 0)},
      {"layer_count", decimal(static_cast<double>(plan.layers.size()), 0)},
      {"max_z", decimal(plan.layers.empty() ? 0 : plan.layers.back().span.top_mm, 3)},
      {"first_layer_size_x", decimal(first.max[0] - first.min[0], 3)},
      {"first_layer_size_y", decimal(first.max[1] - first.min[1], 3)},
  };
  put_extent(out, first, "first_layer_");
  put_extent(out, all, "");
  return out;
}

std::string expand(std::string_view text, const Placeholders& values, std::string_view what) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if ((c == '{' || c == '}') && i + 1 < text.size() && text[i + 1] == c) {
      out += c;
      ++i;
      continue;
    }
    const std::size_t end = c == '{' ? text.find('}', i) : std::string_view::npos;
    if (end == std::string_view::npos || !is_name(text.substr(i + 1, end - i - 1))) {
      out += c;
      continue;
    }
    const std::string_view name = text.substr(i + 1, end - i - 1);
    const auto found = values.find(name);
    if (found == values.end())
      throw std::runtime_error("unknown placeholder {" + std::string(name) + "} in the " + std::string(what));
    out += found->second;
    i = end;
  }
  return out;
}

}  // namespace voidpath::toolpath
