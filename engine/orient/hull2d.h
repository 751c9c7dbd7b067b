#pragma once

#include "engine/orient/cross_section.h"

#include <optional>
#include <vector>

/// Convex outlines in the plane: what a part covers on the bed, what it stands on.
namespace voidpath::orient {

/// Counter-clockwise, no three in line (Andrew's monotone chain). Reorders `points` and drops inner ones.
std::vector<Point2> convex_outline(std::vector<Point2>& points);

/// Distance of p to the outline's border, positive inside; -infinity for an empty outline.
double depth_inside(const std::vector<Point2>& outline, Point2 p);

struct Rectangle {
  double x = 0, y = 0;  ///< sides
  double area() const { return x * y; }
};
/// The smallest by area of those that hold the outline (rotating calipers). x >= y
Rectangle smallest_rectangle(const std::vector<Point2>& outline);

/// An angle (rad, counter-clockwise) that turns the outline so that its axis-aligned extent is at most
/// x by y: 0 if it will do, else the one of the smallest size that exists; nothing when no turn fits. Exact:
/// between the angles at which an edge of the outline is parallel to an axis both extents are sine curves.
std::optional<double> turn_to_fit(const std::vector<Point2>& outline, double x, double y);

}  // namespace voidpath::orient
