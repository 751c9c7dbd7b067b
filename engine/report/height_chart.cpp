#include "engine/report/height_chart.h"

#include "engine/report/markup.h"

#include <algorithm>
#include <cmath>

namespace voidpath::report {

namespace {

constexpr double kLeft = 44, kTop = 12, kPlotWidth = 256, kPlotHeight = 240;
constexpr double kWidth = kLeft + kPlotWidth + 16, kHeight = kTop + kPlotHeight + 46;

/// 1, 2 or 5 times a power of ten: about `count` of them make `range`.
double round_step(double range, int count) {
  const double raw = range / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double f : {1.0, 2.0, 5.0})
    if (f * power >= raw * (1 - 1e-9)) return f * power;
  return 10 * power;
}

struct Axis {
  double most;
  double step;
  int decimals;
};
Axis axis_for(double most, int count, bool whole = false) {
  if (!(most > 0)) return {1, 1, 0};
  const double step = std::max(round_step(most, count), whole ? 1.0 : 0.0);
  const int decimals = step >= 1 ? 0 : static_cast<int>(std::ceil(-std::log10(step) - 1e-9));
  return {most, step, decimals};
}

}  // namespace

std::string height_chart(const std::string& title, const std::vector<Curve>& curves, double height_mm,
                         bool whole) {
  double most = 0;
  for (const Curve& c : curves)
    for (const Step& s : c.steps) most = std::max(most, s.value);
  const Axis across = axis_for(1.04 * most, 5, whole);
  const Axis up = axis_for(height_mm, 6);
  const auto x = [&](double v) { return kLeft + kPlotWidth * v / across.most; };
  const auto y = [&](double h) { return kTop + kPlotHeight * (1 - h / up.most); };

  std::string out = "<svg class=\"chart\" role=\"img\" viewBox=\"0 0 " + brief(kWidth) + ' ' +
                    brief(kHeight) + "\" aria-label=\"" + escaped(title) + " along the height\">\n";
  std::string lines;
  for (double v = 0; v <= across.most * (1 + 1e-9); v += across.step) {
    lines += 'M' + brief(x(v)) + ' ' + brief(kTop) + 'v' + brief(kPlotHeight);
    out += "<text class=\"tick\" text-anchor=\"middle\" x=\"" + brief(x(v)) + "\" y=\"" +
           brief(kTop + kPlotHeight + 16) + "\">" + fixed(v, across.decimals) + "</text>\n";
  }
  for (double h = 0; h <= up.most * (1 + 1e-9); h += up.step) {
    lines += 'M' + brief(kLeft) + ' ' + brief(y(h)) + 'h' + brief(kPlotWidth);
    out += "<text class=\"tick\" text-anchor=\"end\" x=\"" + brief(kLeft - 6) + "\" y=\"" + brief(y(h) + 4) +
           "\">" + fixed(h, up.decimals) + "</text>\n";
  }
  out += "<path class=\"lines\" d=\"" + lines + "\"/>\n";
  out += "<text class=\"tick\" text-anchor=\"middle\" x=\"" + brief(kLeft + kPlotWidth / 2) + "\" y=\"" +
         brief(kHeight - 10) + "\">" + escaped(title) + "</text>\n";
  out += "<text class=\"tick\" text-anchor=\"middle\" transform=\"translate(11 " +
         brief(kTop + kPlotHeight / 2) + ") rotate(-90)\">height above the plate, mm</text>\n";
  for (auto c = curves.rbegin(); c != curves.rend(); ++c) {
    std::string d = 'M' + brief(x(0)) + ' ' + brief(y(0));
    for (const Step& s : c->steps)
      d += 'L' + brief(x(s.value), 2) + ' ' + brief(y(s.bottom_mm), 2) + 'V' + brief(y(s.top_mm), 2);
    d += 'H' + brief(x(0));
    out += "<path class=\"curve " + c->kind + "\" d=\"" + d + "\"/>\n";
  }
  return out + "</svg>\n";
}

}  // namespace voidpath::report
