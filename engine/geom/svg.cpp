#include "engine/geom/svg.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace voidpath::geom {

namespace {

void append(std::string& out, double value) {
  std::array<char, 32> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  out.append(buffer.data(), end);
}

/// y is turned here: SVG counts it downwards.
void append(std::string& out, const Point& p) {
  append(out, to_mm(p.x));
  out += ' ';
  append(out, -to_mm(p.y));
}

void append_path(std::string& out, const std::vector<Point>& points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    out += i == 0 ? 'M' : 'L';
    append(out, points[i]);
  }
}

}  // namespace

void Svg::frame(const std::vector<Point>& points) {
  for (const Point& p : points) {
    if (is_empty_) frame_ = {p, p};
    is_empty_ = false;
    frame_.min = {std::min(frame_.min.x, p.x), std::min(frame_.min.y, p.y)};
    frame_.max = {std::max(frame_.max.x, p.x), std::max(frame_.max.y, p.y)};
  }
}

Svg& Svg::add(const Regions& regions, std::string_view colour) {
  for (const Region& r : regions) {
    body_.append("<path fill-rule=\"evenodd\" fill-opacity=\"0.4\" stroke-width=\"0.02\" fill=\"")
        .append(colour)
        .append("\" stroke=\"")
        .append(colour)
        .append("\" d=\"");
    for (const Ring& ring : rings_of({r})) {
      append_path(body_, ring);
      body_ += 'Z';
      frame(ring);
    }
    body_ += "\"/>\n";
  }
  return *this;
}

Svg& Svg::add(const Polylines& lines, std::string_view colour, double width_mm) {
  for (const Polyline& line : lines) {
    body_.append("<path fill=\"none\" stroke=\"").append(colour).append("\" stroke-width=\"");
    append(body_, width_mm);
    body_ += "\" d=\"";
    append_path(body_, line);
    body_ += "\"/>\n";
    frame(line);
  }
  return *this;
}

Svg& Svg::add(const Point& point, std::string_view colour, double radius_mm) {
  body_.append("<circle fill=\"").append(colour).append("\" r=\"");
  append(body_, radius_mm);
  body_ += "\" cx=\"";
  append(body_, to_mm(point.x));
  body_ += "\" cy=\"";
  append(body_, -to_mm(point.y));
  body_ += "\"/>\n";
  frame({point});
  return *this;
}

std::string Svg::str() const {
  constexpr double kMarginMm = 1;
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"";
  append(out, to_mm(frame_.min.x) - kMarginMm);
  out += ' ';
  append(out, -to_mm(frame_.max.y) - kMarginMm);
  out += ' ';
  append(out, to_mm(frame_.max.x - frame_.min.x) + 2 * kMarginMm);
  out += ' ';
  append(out, to_mm(frame_.max.y - frame_.min.y) + 2 * kMarginMm);
  return out + "\">\n" + body_ + "</svg>\n";
}

}  // namespace voidpath::geom
