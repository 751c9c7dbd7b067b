#include "engine/evaluate/chart.h"

#include "engine/orient/words.h"

#include <algorithm>
#include <cmath>

namespace voidpath::evaluate {

namespace {

using orient::number;

constexpr double kWidth = 860;
constexpr double kLeft = 120;
constexpr double kRight = 20;
constexpr double kPlot = kWidth - kLeft - kRight;

std::string coordinate(double v) { return number(v, 1); }

std::string svg_begin(double height) {
  return "<svg viewBox=\"0 0 " + coordinate(kWidth) + " " + coordinate(height) + "\" role=\"img\">\n";
}

std::string rect(double x, double y, double w, double h, const std::string& css, const std::string& title) {
  return "<rect x=\"" + coordinate(x) + "\" y=\"" + coordinate(y) + "\" width=\"" +
         coordinate(std::max(w, 0.3)) + "\" height=\"" + coordinate(h) + "\" class=\"" + css + "\">" +
         (title.empty() ? "" : "<title>" + escaped(title) + "</title>") + "</rect>\n";
}

std::string line(double x1, double y1, double x2, double y2, const std::string& css) {
  return "<line x1=\"" + coordinate(x1) + "\" y1=\"" + coordinate(y1) + "\" x2=\"" + coordinate(x2) +
         "\" y2=\"" + coordinate(y2) + "\" class=\"" + css + "\"/>\n";
}

/// `anchor`: start, middle or end.
std::string label(double x, double y, const std::string& anchor, const std::string& text) {
  return "<text x=\"" + coordinate(x) + "\" y=\"" + coordinate(y) + "\" text-anchor=\"" + anchor + "\">" +
         escaped(text) + "</text>\n";
}

/// A logarithmic axis across the plot.
struct RatioAxis {
  double low, high;
  double at(double ratio) const {
    return kLeft + kPlot * std::log(std::clamp(ratio, low, high) / low) / std::log(high / low);
  }
};

std::string draw_axis(const RatioAxis& axis, double top, double bottom, const std::string& title) {
  std::string out;
  double last = -1e9;
  for (const double tick : {0.1, 0.2, 0.3, 0.4,  0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1,  1.2,
                            1.3, 1.4, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0, 20.0}) {
    if (tick < axis.low * 0.999 || tick > axis.high * 1.001) continue;
    const double x = axis.at(tick);
    const bool is_one = tick == 1.0;
    if (x - last < 34 && !is_one) continue;
    out +=
        line(x, top, x, bottom, is_one ? "one" : "grid") + label(x, bottom + 16, "middle", number(tick, 2));
    last = x;
  }
  return out + label(kLeft + kPlot / 2, bottom + 36, "middle", title);
}

/// 1, 2 or 5 times a power of ten: some four of them to `most`.
double tick_step(double most) {
  const double raw = std::max(most, 1e-9) / 4;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (raw <= factor * power) return factor * power;
  return 10 * power;
}

std::string draw_values(double most, double top, double bottom, const std::string& title) {
  std::string out;
  const double step = tick_step(most);
  for (double v = 0; v <= most * 1.0001; v += step) {
    const double y = bottom - (bottom - top) * v / most;
    out += line(kLeft, y, kLeft + kPlot, y, "grid") + label(kLeft - 6, y + 4, "end", number(v, 2));
  }
  return out + "<text transform=\"translate(" + coordinate(kLeft - 62) + "," +
         coordinate((top + bottom) / 2) + ") rotate(-90)\" text-anchor=\"middle\">" + escaped(title) +
         "</text>\n";
}

double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string page_begin(const std::string& title) {
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         escaped(title) + R"(</title>
<style>
:root { color-scheme: light dark; --ink: #1b1f24; --paper: #fff; --soft: #6b7480; --grid: #dde1e6; --same: #9aa3ad;
  --less: #2a7f62; --more: #b3541e; --dot: #3465a4; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e8ea; --paper: #16191d; --soft: #9aa3ad; --grid: #2c3238;
  --same: #6b7480; --less: #4fb08c; --more: #e08a4f; --dot: #7aa7e0; } }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 62rem;
  margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2.2rem; }
svg { width: 100%; height: auto; } svg text { font: 12px system-ui, sans-serif; fill: var(--ink); }
table { border-collapse: collapse; font-size: .85rem; } th, td { padding: .2rem .55rem; text-align: right;
  border-bottom: 1px solid var(--grid); white-space: nowrap; } th:first-child, td:first-child { text-align: left; }
.scroll { overflow-x: auto; } .note { color: var(--soft); } .best { font-weight: 600; }
.grid { stroke: var(--grid); } .one { stroke: var(--soft); stroke-dasharray: 3 3; }
.same { fill: var(--same); } .less { fill: var(--less); } .more { fill: var(--more); }
.dot { fill: var(--dot); fill-opacity: .55; } .median { stroke: var(--ink); stroke-width: 3; }
.s0 { fill: #3465a4; } .s1 { fill: #e08a4f; } .s2 { fill: #4fa34f; } .s3 { fill: #b04a5a; } .s4 { fill: #8868b0; }
.s5 { fill: #8a6d4b; } .s6 { fill: #d080b0; } .s7 { fill: #8f979f; } .s8 { fill: #a8a83c; } .s9 { fill: #3ca8b4; }
</style></head><body>
<h1>)" + escaped(title) +
         "</h1>\n";
}

std::string page_end() { return "</body></html>\n"; }

std::string ratio_histogram(const std::vector<double>& ratios, double same, const std::string& axis_title) {
  constexpr double kTop = 14, kBottom = 250;
  constexpr int kSide = 14;      // bars each side of 1
  constexpr double kBar = 0.05;  // of a natural logarithm: some 5 %
  std::vector<std::size_t> counts(2 * kSide + 1);
  for (const double r : ratios) {
    int bar = 0;
    if (r > 1 + same)
      bar = std::min(kSide, 1 + static_cast<int>(std::log(r) / kBar));
    else if (r < 1 - same)
      bar = std::max(-kSide, -1 - static_cast<int>(-std::log(r) / kBar));
    ++counts[static_cast<std::size_t>(kSide + bar)];
  }
  const double most = std::max(1.0, static_cast<double>(*std::max_element(counts.begin(), counts.end())));
  std::string out = svg_begin(kBottom + 46) + draw_values(most, kTop, kBottom, "models");
  const double width = kPlot / static_cast<double>(counts.size());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const int bar = static_cast<int>(i) - kSide;
    const double x = kLeft + width * static_cast<double>(i);
    const double from = std::exp(kBar * (bar > 0 ? bar - 1 : bar)),
                 to = std::exp(kBar * (bar > 0 ? bar : bar + 1));
    const bool first = bar == -kSide, last = bar == kSide;
    const std::string range = bar == 0 ? "the same"
                              : first  ? "below " + number(to, 2)
                              : last   ? "above " + number(from, 2)
                                       : number(from, 2) + " to " + number(to, 2);
    const double h = (kBottom - kTop) * static_cast<double>(counts[i]) / most;
    if (counts[i] > 0)
      out += rect(x + 1, kBottom - h, width - 2, h,
                  bar == 0  ? "same"
                  : bar < 0 ? "less"
                            : "more",
                  range + ": " + std::to_string(counts[i]));
    if (bar == 0) out += label(x + width / 2, kBottom + 16, "middle", "1");
    if (bar != 0 && bar % 3 == 0) {
      const double edge = bar > 0 ? x + width : x;
      out += label(edge, kBottom + 16, "middle", number(std::exp(kBar * bar), 2));
    }
  }
  return out + label(kLeft + kPlot / 2, kBottom + 36, "middle", axis_title) + "</svg>\n";
}

std::string ratio_strips(const std::vector<StripRow>& rows, const std::string& axis_title) {
  constexpr double kTop = 10, kRow = 34;
  RatioAxis axis{0.99, 1.1};
  for (const StripRow& row : rows)
    for (const double r : row.ratios) {
      axis.low = std::min(axis.low, r / 1.01);
      axis.high = std::max(axis.high, r * 1.01);
    }
  const double bottom = kTop + kRow * static_cast<double>(rows.size());
  std::string out = svg_begin(bottom + 46) + draw_axis(axis, kTop, bottom, axis_title);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const StripRow& row = rows[k];
    const double y = kTop + kRow * (static_cast<double>(k) + 0.5);
    out += label(kLeft - 8, y + 4, "end", row.label);
    for (std::size_t i = 0; i < row.ratios.size(); ++i) {
      // Spread over the row's height, the same way each time.
      const double shift = (static_cast<double>(i * 7 % 11) - 5) * 1.8;
      out += "<circle cx=\"" + coordinate(axis.at(row.ratios[i])) + "\" cy=\"" + coordinate(y + shift) +
             "\" r=\"3.5\" class=\"dot\"><title>" +
             escaped((i < row.names.size() ? row.names[i] + ": " : "") + number(row.ratios[i], 3)) +
             "</title></circle>\n";
    }
    if (row.ratios.empty()) continue;
    const double x = axis.at(median_of(row.ratios));
    out += line(x, y - 13, x, y + 13, "median");
  }
  return out + "</svg>\n";
}

std::string stacked_columns(const std::vector<Stack>& stacks, const std::vector<std::string>& column_names,
                            const std::string& value_title, const std::string& column_title) {
  constexpr double kTop = 14, kBottom = 300;
  constexpr std::size_t kMostColumns = 720;  // about one a pixel
  const std::size_t columns = column_names.size();
  if (columns == 0) return {};
  const std::size_t group = (columns + kMostColumns - 1) / kMostColumns;
  const std::size_t shown = (columns + group - 1) / group;
  const auto mean = [&](const Stack& s, std::size_t column) {
    const std::size_t from = column * group, to = std::min(from + group, columns);
    double sum = 0;
    for (std::size_t i = from; i < to; ++i) sum += i < s.values.size() ? s.values[i] : 0;
    return sum / static_cast<double>(to - from);
  };
  double most = 1e-9;
  for (std::size_t c = 0; c < shown; ++c) {
    double sum = 0;
    for (const Stack& s : stacks) sum += mean(s, c);
    most = std::max(most, sum);
  }
  const double legend = 22 * std::ceil(static_cast<double>(stacks.size()) / 4.0);
  std::string out = svg_begin(kBottom + 56 + legend) + draw_values(most, kTop, kBottom, value_title);
  const double width = kPlot / static_cast<double>(shown);
  const double gap = width > 4 ? 1 : 0;
  for (std::size_t c = 0; c < shown; ++c) {
    const std::size_t last = std::min((c + 1) * group, columns) - 1;
    const std::string name = column_names[c * group] + (group > 1 ? " to " + column_names[last] : "");
    double y = kBottom;
    for (std::size_t k = 0; k < stacks.size(); ++k) {
      const double value = mean(stacks[k], c);
      if (value <= 0) continue;
      const double h = (kBottom - kTop) * value / most;
      y -= h;
      out += rect(kLeft + width * static_cast<double>(c), y, width - gap, h, "s" + std::to_string(k % 10),
                  name + ", " + stacks[k].name + ": " + number(value, 1));
    }
  }
  for (std::size_t c = 0; c < shown; c += std::max<std::size_t>(1, shown / 8))
    out += label(kLeft + width * (static_cast<double>(c) + 0.5), kBottom + 16, "middle",
                 column_names[c * group]);
  out += label(kLeft + kPlot / 2, kBottom + 36, "middle", column_title);
  for (std::size_t k = 0; k < stacks.size(); ++k) {
    const double x = kLeft + kPlot / 4 * static_cast<double>(k % 4);
    const double y = kBottom + 54 + 22 * static_cast<double>(k / 4);
    out +=
        rect(x, y - 10, 12, 12, "s" + std::to_string(k % 10), "") + label(x + 18, y, "start", stacks[k].name);
  }
  return out + "</svg>\n";
}

}  // namespace voidpath::evaluate
