#include "engine/orient/feasible.h"

#include "engine/orient/words.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace voidpath::orient {

namespace {

struct Contact {
  double area_mm2 = 0;
  std::vector<Point2> points;  ///< of everything within the depth
};

/// Height above the plate when the part stands on `end`.
double above_plate(const Projection& p, End end, Index v) {
  return end == End::bottom ? p.h[v] - p.h_min : p.h_max - p.h[v];
}

Contact find_contact(const Solid& solid, const Projection& p, End end, double depth) {
  Contact out;
  auto is_near = [&](Index v) { return above_plate(p, end, v) <= depth; };
  auto add = [&](const mesh::Triangle& t) {
    const std::array<double, 3> h{above_plate(p, end, t[0]), above_plate(p, end, t[1]),
                                  above_plate(p, end, t[2])};
    // The part of the facet within the depth (Sutherland and Hodgman against one plane).
    std::array<Point2, 4> poly;
    std::size_t n = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t m = (k + 1) % 3;
      const Point2 a{p.x[t[k]], p.y[t[k]]};
      const Point2 b{p.x[t[m]], p.y[t[m]]};
      if (h[k] <= depth) poly[n++] = a;
      if ((h[k] <= depth) != (h[m] <= depth)) {
        const double s = (depth - h[k]) / (h[m] - h[k]);
        poly[n++] = {a.x + s * (b.x - a.x), a.y + s * (b.y - a.y)};
      }
    }
    double twice = 0;
    for (std::size_t k = 1; k + 1 < n; ++k)
      twice += (poly[k].x - poly[0].x) * (poly[k + 1].y - poly[0].y) -
               (poly[k + 1].x - poly[0].x) * (poly[k].y - poly[0].y);
    // Facets that look at the plate: clockwise seen from above.
    const double towards_plate = end == End::bottom ? -twice : twice;
    if (towards_plate > 0) out.area_mm2 += towards_plate / 2;
    out.points.insert(out.points.end(), poly.begin(), poly.begin() + static_cast<std::ptrdiff_t>(n));
  };
  for (Index v = 0; v < solid.vertices.size(); ++v) {
    if (!is_near(v)) continue;
    for (Index k = solid.first_facet_at[v]; k < solid.first_facet_at[v + 1]; ++k) {
      const mesh::Triangle& t = solid.triangles[solid.facets_at[k]];
      // Once each, at the first of its corners that is near.
      if (std::none_of(t.begin(), t.end(), [&](Index u) { return u < v && is_near(u); })) add(t);
    }
  }
  return out;
}

std::vector<Point2> footprint(const std::vector<Index>& hull_vertices, const Projection& p) {
  std::vector<Point2> points;
  points.reserve(hull_vertices.size());
  for (const Index v : hull_vertices) points.push_back({p.x[v], p.y[v]});
  return convex_outline(points);
}

std::string size_text(double a, double b) { return number(a, 1) + " × " + number(b, 1) + " mm"; }

}  // namespace

std::string why_not_printable(const Solid& solid, const std::vector<Index>& hull_vertices,
                              const Projection& p, End end, const PrintLimits& limits) {
  const double height = p.h_max - p.h_min;
  if (height > limits.volume_mm[2] + kHeightNoise)
    return "too tall: " + number(height, 1) + " mm, the printer has " + number(limits.volume_mm[2], 1) +
           " mm";
  const double bed_x = limits.volume_mm[0] - 2 * limits.bed_margin_mm;
  const double bed_y = limits.volume_mm[1] - 2 * limits.bed_margin_mm;
  if (2 * solid.radius_mm > std::min(bed_x, bed_y)) {
    const std::vector<Point2> outline = footprint(hull_vertices, p);
    if (!turn_to_fit(outline, bed_x, bed_y)) {
      const Rectangle r = smallest_rectangle(outline);
      return "too large for the bed: covers " + size_text(r.x, r.y) + ", the bed takes " +
             size_text(bed_x, bed_y);
    }
  }
  Contact contact = find_contact(solid, p, end, limits.contact_depth_mm);
  if (contact.area_mm2 < limits.min_contact_mm2) {
    // The rectangle along the projection's axes is no smaller than the smallest: most often it settles this.
    const double around = (p.x_max - p.x_min) * (p.y_max - p.y_min);
    const bool enough = around > 0 && contact.area_mm2 >= limits.min_contact_share * around;
    const double rectangle = enough ? around : smallest_rectangle(footprint(hull_vertices, p)).area();
    if (!enough && (contact.area_mm2 < limits.min_contact_share * rectangle || rectangle <= 0))
      return "too little to stand on: " + number(contact.area_mm2, 1) + " mm² touch the plate";
  }
  // Seen along the direction; for the part upside down the same picture mirrored, which changes no distance.
  const Vec3& c = solid.centre_of_mass;
  const Point2 centre{p.e1.dot(c), p.e2.dot(c)};
  const double inside = depth_inside(convex_outline(contact.points), centre);
  if (inside < limits.stability_margin_mm)
    return inside < 0 ? "would tip over: its centre of mass lies " + number(-inside, 1) +
                            " mm outside what it stands on"
                      : "could tip over: its centre of mass lies only " + number(inside, 2) +
                            " mm inside what it stands on";
  return {};
}

std::optional<double> bed_turn(const mesh::TriangleMesh& mesh, const Vec3& direction,
                               const PrintLimits& limits) {
  const geom::Mat3 r = mesh::rotation_to_up(direction).toRotationMatrix();
  std::vector<Point2> points;
  points.reserve(mesh.vertices.size());
  for (const Vec3& v : mesh.vertices) points.push_back({r.row(0).dot(v), r.row(1).dot(v)});
  return turn_to_fit(convex_outline(points), limits.volume_mm[0] - 2 * limits.bed_margin_mm,
                     limits.volume_mm[1] - 2 * limits.bed_margin_mm);
}

}  // namespace voidpath::orient
