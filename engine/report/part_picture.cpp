#include "engine/report/part_picture.h"

#include "engine/report/markup.h"
#include "engine/report/raster.h"
#include "engine/report/view.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace voidpath::report {

namespace {

using geom::Vec3;

constexpr double kWidth = 420;  ///< room for part and plate, px
constexpr double kHeight = 380;
constexpr double kMargin = 14;
constexpr double kRuler = 44;  ///< for the height's dimension line, left of the part
constexpr std::size_t kMostBytes = 500'000;

/// Borders of part and plate in the view, mm.
struct Extent {
  double left = 1e300, right = -1e300, bottom = 1e300, top = -1e300;
  void add(const Vec3& seen) {
    left = std::min(left, seen.x());
    right = std::max(right, seen.x());
    bottom = std::min(bottom, seen.y());
    top = std::max(top, seen.y());
  }
};

Extent extent_of(const Standing& part, const View& view) {
  Extent out;
  const Plate plate = plate_under(part.box);
  for (const double x : {plate.x0, plate.x1})
    for (const double y : {plate.y0, plate.y1}) out.add(view.see({x, y, 0}));
  for (const Vec3& v : part.mesh.vertices) out.add(view.see(v));
  return out;
}

/// From the view to the drawing.
class Sheet {
 public:
  Sheet(const Extent& e, const Frame& frame) : scale_(frame.px_per_mm) {
    left_ = e.left - ((frame.width + kRuler) / scale_ - (e.right - e.left)) / 2;
    top_ = e.bottom + (frame.height - kMargin) / scale_;
  }
  double x(double right_mm) const { return (right_mm - left_) * scale_; }
  double y(double up_mm) const { return (top_ - up_mm) * scale_; }
  std::string point(const Vec3& seen) const { return brief(x(seen.x())) + ' ' + brief(y(seen.y())); }

 private:
  double scale_, left_, top_;
};

std::string draw_plate(const Plate& p, const View& view, const Sheet& sheet) {
  const auto at = [&](double x, double y) { return sheet.point(view.see({x, y, 0})); };
  std::string out = "<path class=\"plate\" d=\"M" + at(p.x0, p.y0) + 'L' + at(p.x1, p.y0) + 'L' +
                    at(p.x1, p.y1) + 'L' + at(p.x0, p.y1) + "Z\"/>\n<path class=\"grid\" d=\"";
  for (double x = std::ceil(p.x0 / p.grid) * p.grid; x <= p.x1; x += p.grid)
    out += 'M' + at(x, p.y0) + 'L' + at(x, p.y1);
  for (double y = std::ceil(p.y0 / p.grid) * p.grid; y <= p.y1; y += p.grid)
    out += 'M' + at(p.x0, y) + 'L' + at(p.x1, y);
  return out + "\"/>\n";
}

/// The height, beside the box's left corner.
std::string draw_ruler(const Standing& part, const View& view, const Sheet& sheet, double left_px) {
  const double h = part.box.max.z();
  const Vec3 foot = view.see({part.box.min.x(), part.box.min.y(), 0});
  const Vec3 head = view.see({part.box.min.x(), part.box.min.y(), h});
  const double x = left_px - 12;
  const double y0 = sheet.y(foot.y());
  const double y1 = sheet.y(head.y());
  const std::string sx = brief(x);
  std::string out = "<path class=\"ruler\" d=\"M" + sx + ' ' + brief(y0) + 'L' + sx + ' ' + brief(y1);
  for (const double y : {y0, y1}) out += 'M' + brief(x - 4) + ' ' + brief(y) + "h8";
  out += "\"/>\n<text class=\"dim\" text-anchor=\"middle\" transform=\"translate(" + brief(x - 7) + ' ' +
         brief((y0 + y1) / 2) + ") rotate(-90)\">" + fixed(h, 1) + " mm</text>\n";
  return out;
}

}  // namespace

Frame common_frame(const Standing& a, const Standing& b) {
  const View view;
  const Extent ea = extent_of(a, view);
  const Extent eb = extent_of(b, view);
  const double width = std::max({ea.right - ea.left, eb.right - eb.left, 1e-3});
  const double height = std::max({ea.top - ea.bottom, eb.top - eb.bottom, 1e-3});
  Frame out;
  out.px_per_mm = std::min(kWidth / width, kHeight / height);
  out.width = kWidth + kRuler + 2 * kMargin;
  out.height = height * out.px_per_mm + 2 * kMargin;
  return out;
}

std::string part_picture(const Standing& part, const Frame& frame, const std::string& label) {
  const View view;
  const Extent e = extent_of(part, view);
  const Sheet sheet(e, frame);
  double fine = 2.0;  // pixels of the painting per px, for sharp screens
  std::string rows;
  for (;; fine /= 1.5) {
    Window w;
    w.px_per_mm = frame.px_per_mm * fine;
    w.left_mm = e.left;
    w.top_mm = e.top;
    w.width = static_cast<int>(std::ceil((e.right - e.left) * w.px_per_mm)) + 1;
    w.height = static_cast<int>(std::ceil((e.top - e.bottom) * w.px_per_mm)) + 1;
    rows = rows_of(paint(part, view, w));
    if (rows.size() <= kMostBytes) break;
  }
  std::string out = "<svg class=\"part\" role=\"img\"";
  attribute(out, "viewBox", "0 0 " + brief(frame.width) + ' ' + brief(frame.height));
  attribute(out, "aria-label", escaped(label));
  out += ">\n" + draw_plate(plate_under(part.box), view, sheet);
  // Strokes a little wider than a row leave no seams.
  out += "<g fill=\"none\" stroke-width=\"1.35\" transform=\"translate(" + brief(sheet.x(e.left), 2) + ' ' +
         brief(sheet.y(e.top) + 0.5 / fine, 2) + ") scale(" + brief(1 / fine, 4) + ")\">\n" + rows + "</g>\n";
  out += draw_ruler(part, view, sheet, sheet.x(e.left));
  return out + "</svg>\n";
}

}  // namespace voidpath::report
