#include "engine/evaluate/layer_times.h"

#include "engine/evaluate/chart.h"
#include "engine/gcode/comments.h"
#include "engine/gcode/reader.h"
#include "engine/orient/words.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <numeric>

namespace voidpath::evaluate {

namespace {

using orient::number;

/// More features than this share the last one's colour and name.
constexpr std::size_t kMostFeatures = 10;

/// A run of lines of one feature within one layer: comments cut the file there.
struct Stretch {
  std::size_t first_line = 0;
  std::string feature;
  double seconds = 0;
};

std::vector<Stretch> cut_by_comments(const std::filesystem::path& file, const run::Context& ctx) {
  std::vector<Stretch> out = {{0, "Other", 0}};
  std::error_code ignored;
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file, ignored)) return out;  // whoever times it says what is wrong
  gcode::LineReader reader(in);
  std::string_view text;
  for (std::size_t line = 0; reader.next(text); ++line) {
    if (line % 4096 == 0) ctx.check();
    const gcode::Remark remark = gcode::read_comment(gcode::split_line(text).comment);
    if (remark.kind == gcode::Remark::Kind::none) continue;
    const std::string feature =
        remark.kind == gcode::Remark::Kind::feature ? std::string(remark.feature) : out.back().feature;
    out.push_back({line, feature, 0});
  }
  return out;
}

/// Puts the stretches' times where the layers are, features with most time first.
void sort_into_layers(const std::vector<Stretch>& stretches, LayerTimes& out) {
  const auto& layers = out.estimate.layers;
  std::map<std::string, std::vector<double>> by_feature;
  std::size_t layer = 0;
  for (const Stretch& s : stretches) {
    while (layer + 1 < layers.size() && layers[layer + 1].first_line <= s.first_line) ++layer;
    if (s.seconds <= 0 || layers.empty() || s.first_line < layers.front().first_line) continue;
    auto& seconds = by_feature[s.feature];
    seconds.resize(layers.size());
    seconds[layer] += s.seconds;
  }
  std::vector<std::pair<double, std::string>> order;
  for (const auto& [name, seconds] : by_feature)
    order.emplace_back(-std::accumulate(seconds.begin(), seconds.end(), 0.0), name);
  std::sort(order.begin(), order.end());
  for (const auto& [time, name] : order) {
    if (out.features.size() < kMostFeatures) {
      out.features.push_back(name);
      out.seconds.push_back(by_feature[name]);
      continue;
    }
    out.features.back() = "others";
    for (std::size_t i = 0; i < layers.size(); ++i) out.seconds.back()[i] += by_feature[name][i];
  }
}

std::string clock_text(double seconds) {
  if (seconds < 60) return number(seconds, 1) + " s";
  const long total = std::lround(seconds);
  const auto two = [](long v) { return (v < 10 ? "0" : "") + std::to_string(v); };
  if (total < 3600) return std::to_string(total / 60) + " min " + two(total % 60) + " s";
  return std::to_string(total / 3600) + " h " + two(total / 60 % 60) + " min";
}

std::string totals(const gcode::Estimate& e) {
  std::string out = "<table>\n";
  const auto row = [&](const std::string& name, double seconds) {
    if (seconds > 0)
      out += "<tr><td>" + escaped(name) + "</td><td>" + clock_text(seconds) + "</td><td>" +
             number(100 * seconds / e.predicted_s, 1) + " %</td></tr>\n";
  };
  row("all", e.predicted_s);
  row("extruding", e.extruding_s);
  row("travel", e.travel_s);
  row("retraction", e.retract_s);
  row("dwelling", e.dwell_s);
  for (const auto& [name, seconds] : e.by_feature) row("extruding: " + name, seconds);
  return out + "</table>\n";
}

}  // namespace

LayerTimes time_layers(const std::filesystem::path& file, const motion::MachineLimits& limits,
                       const run::Context& ctx) {
  std::vector<Stretch> stretches = cut_by_comments(file, ctx);
  std::size_t at = 0;
  LayerTimes out;
  // Motion comes in the order of the lines.
  out.estimate = gcode::estimate_file(file, limits, ctx, [&](std::size_t line, double begin_s, double end_s) {
    while (at + 1 < stretches.size() && stretches[at + 1].first_line <= line) ++at;
    stretches[at].seconds += end_s - begin_s;
  });
  if (stretches.size() > 1) {
    sort_into_layers(stretches, out);
  } else {
    out.features = {"all"};
    out.seconds.emplace_back();
    for (const auto& layer : out.estimate.layers) out.seconds.back().push_back(layer.seconds);
  }
  return out;
}

std::string layer_page(const std::string& title, const LayerTimes& times) {
  const gcode::Estimate& e = times.estimate;
  std::string out = page_begin(title + ": " + clock_text(e.predicted_s));
  out += "<p>" + std::to_string(e.layers.size()) + " layers, " + std::to_string(e.moves) + " moves, " +
         number(e.extruding_mm / 1000, 1) + " m extruding, " + number(e.travel_mm / 1000, 1) + " m travel, " +
         number(e.filament_mm / 1000, 2) + " m of filament. Machine limits from the " +
         escaped(e.limits_from) + ". Heating is not in the time.</p>\n";
  // Half a second is what no one notices.
  if (e.serial_limited_s >= 0.5)
    out += "<p><b>Limited by the serial line: " + clock_text(e.serial_limited_s) + " of " +
           clock_text(e.predicted_s) + "</b>: segments come shorter than the line can feed them.</p>\n";
  else
    out += "<p class=\"note\">The serial line costs no time.</p>\n";
  std::vector<Stack> stacks;
  for (std::size_t i = 0; i < times.features.size(); ++i)
    stacks.push_back({times.features[i], times.seconds[i]});
  std::vector<std::string> names;
  for (const auto& layer : e.layers) names.push_back(number(layer.z_mm, 2) + " mm");
  if (!names.empty()) {
    out +=
        "<h2>Time by layer</h2>\n<p class=\"note\">Travel and retraction count to the feature whose lines "
        "ask for "
        "them.</p>\n" +
        stacked_columns(stacks, names, "seconds", "height of the layer");
  }
  out += "<h2>Totals</h2>\n" + totals(e);
  for (const std::string& note : e.notes) out += "<p class=\"note\">" + escaped(note) + "</p>\n";
  return out + page_end();
}

}  // namespace voidpath::evaluate
