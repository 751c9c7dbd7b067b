#include "daemon/cli/flags.h"
#include "daemon/cli/offline.h"
#include "engine/evaluate/layer_times.h"

#include <cstdio>
#include <fstream>
#include <iostream>

#include <nlohmann/json.hpp>

namespace voidpath::cli {

namespace {

void print_estimate(const std::string& file, const gcode::Estimate& e) {
  std::printf("%s: %s\n", file.c_str(), duration_text(e.predicted_s).c_str());
  const auto row = [&](const char* name, double s) {
    if (s > 0)
      std::printf("  %-26s %12s %6.1f %%\n", name, duration_text(s).c_str(), 100 * s / e.predicted_s);
  };
  row("extruding", e.extruding_s);
  row("travel", e.travel_s);
  row("retraction", e.retract_s);
  row("dwelling", e.dwell_s);
  for (const auto& [name, seconds] : e.by_feature) row(("- " + name).c_str(), seconds);
  std::printf("  %zu layers, %zu moves, %.1f m extruding, %.1f m travel, %.2f m of filament\n",
              e.layers.size(), e.moves, e.extruding_mm / 1000, e.travel_mm / 1000, e.filament_mm / 1000);
  if (e.serial_limited_s >= 0.5)
    std::printf("  limited by the serial line: %s of %s\n", duration_text(e.serial_limited_s).c_str(),
                duration_text(e.predicted_s).c_str());
  if (e.homing_s > 0)
    std::printf("  homing takes about %s, counted only in mid-print\n", duration_text(e.homing_s).c_str());
  if (e.after_heating_s < e.predicted_s)
    std::printf("  %s of it after heating; waits for a temperature are not counted\n",
                duration_text(e.after_heating_s).c_str());
  std::printf("  machine limits from the %s\n", e.limits_from.c_str());
  for (const std::string& note : e.notes) std::printf("  %s\n", note.c_str());
}

void write_report(const std::string& file, const std::string& html) {
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out << html;
  out.close();
  if (!out) throw std::runtime_error(file + ": cannot be written");
}

}  // namespace

int estimate_command(const std::vector<std::string>& args) {
  CLI::App app("Times G-code by the printer's own planner", "estimate");
  CommonFlags common;
  std::string file, report;
  app.add_option("file", file, "a G-code file, any slicer's")->required();
  app.add_option("--report", report, "writes an HTML page with a picture of time by layer");
  add_common(app, common);
  if (!parse(app, args)) return 0;

  const Settings s = settings_from(common, {});
  const run::Context ctx = console_context(common.threads);
  gcode::Estimate e;
  if (report.empty()) {
    e = gcode::estimate_file(file, s.options.limits, ctx);
  } else {
    const evaluate::LayerTimes times = evaluate::time_layers(file, s.options.limits, ctx);
    write_report(report, evaluate::layer_page(std::filesystem::path(file).filename().string(), times));
    e = times.estimate;
  }
  end_progress();
  if (!common.json) {
    print_estimate(file, e);
    return 0;
  }
  const nlohmann::ordered_json j = {{"predicted_s", e.predicted_s},
                                    {"extruding_s", e.extruding_s},
                                    {"travel_s", e.travel_s},
                                    {"retract_s", e.retract_s},
                                    {"dwell_s", e.dwell_s},
                                    {"homing_s", e.homing_s},
                                    {"after_heating_s", e.after_heating_s},
                                    {"serial_limited_s", e.serial_limited_s},
                                    {"moves", e.moves},
                                    {"layers", e.layers.size()},
                                    {"extruding_mm", e.extruding_mm},
                                    {"travel_mm", e.travel_mm},
                                    {"filament_mm", e.filament_mm},
                                    {"by_feature", e.by_feature},
                                    {"limits_from", e.limits_from}};
  std::cout << j.dump(2) << '\n';
  return 0;
}

}  // namespace voidpath::cli
