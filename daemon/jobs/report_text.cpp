#include "daemon/jobs/report_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace voidpath::daemon {
namespace {

std::string fixed(double value, int decimals) {
  char buffer[64];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals);
  return std::string(buffer, end.ptr);
}

/// "1 h 41 min 17 s"
std::string duration(double seconds) {
  const long total = std::lround(seconds);
  std::string out;
  if (total >= 3600) out += std::to_string(total / 3600) + " h ";
  if (total >= 60) out += std::to_string(total / 60 % 60) + " min ";
  return out + std::to_string(total % 60) + " s";
}

std::string duration_or_dash(const std::optional<double>& seconds) {
  return seconds ? duration(*seconds) : "-";
}

std::string padded(std::string text, std::size_t width) {
  // Counted in characters, not bytes, so that "³" does not shift the column.
  const auto characters = static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
  return characters < width ? std::string(width - characters, ' ') + text : text;
}

/// The four criteria and the predicted time, as delivered and as turned, side by side.
std::string comparison(const JobFacts& facts) {
  constexpr std::size_t kColumn = 20;
  std::string out = padded("", 18) + padded("as delivered", kColumn) + padded("as turned", kColumn) + "\n";
  const auto row = [&](std::string name, const std::string& before, const std::string& now) {
    name.resize(18, ' ');
    out += name + padded(before, kColumn) + padded(now, kColumn) + "\n";
  };
  const orient::Criteria& a = *facts.criteria_as_delivered;
  const orient::Criteria& b = *facts.criteria;
  row("  height", fixed(a.height_mm, 1) + " mm", fixed(b.height_mm, 1) + " mm");
  row("  trapped volume", fixed(a.trapped_mm3 / 1000, 2) + " cm³", fixed(b.trapped_mm3 / 1000, 2) + " cm³");
  row("  regions a slice", fixed(a.contours, 2), fixed(b.contours, 2));
  row("  void distance", fixed(a.void_mm, 2) + " mm", fixed(b.void_mm, 2) + " mm");
  row("  predicted time",
      (facts.as_delivered_s && facts.as_delivered_is_rough ? "about " : "") +
          duration_or_dash(facts.as_delivered_s),
      duration(facts.predicted_s));
  return out;
}

}  // namespace

std::string report_text(const Job& job, const PrintRecord& record) {
  const auto& facts = record.facts;
  std::string out = job.file_name() + ": " + record.state + "\n";
  const auto line = [&](const std::string& name, const std::string& value) {
    if (!value.empty()) out += name + ": " + value + "\n";
  };
  line("reason", record.reason);
  line("printer", record.printer + (record.firmware.empty() ? "" : ", " + record.firmware));
  line("started", record.started);
  line("ended", record.ended);
  if (!facts.method.empty()) line("orientation", facts.method + (facts.why.empty() ? "" : ": " + facts.why));
  if (!facts.limits.empty())
    line("limits", "as the " + (facts.limits_from.empty() ? "profile" : facts.limits_from) +
                       " has them: " + facts.limits);
  if (facts.direction && facts.method != "gcode") {
    const auto& d = *facts.direction;
    line("what points up", fixed(d[0], 4) + ", " + fixed(d[1], 4) + ", " + fixed(d[2], 4));
    if (facts.criteria && facts.criteria_as_delivered) out += comparison(facts);
  }
  if (facts.layers > 0) line("layers", std::to_string(facts.layers));
  if (facts.filament_mm > 0) line("filament", fixed(facts.filament_mm / 1000, 2) + " m");
  if (facts.predicted_s > 0)
    line("predicted", duration(facts.predicted_s) + " (" + fixed(facts.predicted_s, 1) + " s)");
  if (record.measured_s) {
    const double off = facts.predicted_s > 0 ? 100 * (facts.predicted_s / *record.measured_s - 1) : 0;
    line("measured", duration(*record.measured_s) + " (" + fixed(*record.measured_s, 1) + " s)" +
                         (facts.predicted_s > 0 ? ", predicted " + fixed(std::abs(off), 2) + " % " +
                                                      (off < 0 ? "too short" : "too long")
                                                : ""));
  }
  if (record.total_s) {
    line("heating", duration(record.heating_s));
    line("total", duration(*record.total_s));
  }
  if (record.doubts > 0)
    line("doubts",
         std::to_string(record.doubts) + " signs that the printer obeyed a line damaged on its way");
  for (const auto& note : facts.notes) line("note", note);
  return out;
}

}  // namespace voidpath::daemon
