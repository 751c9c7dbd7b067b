#pragma once

#include <string>
#include <vector>

namespace voidpath::report {

/// A value that is constant from one height to the next.
struct Step {
  double bottom_mm = 0, top_mm = 0;
  double value = 0;
};

struct Curve {
  std::vector<Step> steps;  ///< lowest first
  std::string kind;         ///< CSS class: "chosen", "delivered"
};

/// SVG: step curves over the height, which runs upwards as the part stands. `title` says what the values are
/// and in what unit. `height_mm` is the tallest to be shown; the first curve lies on top. `whole`: values are
/// whole numbers.
std::string height_chart(const std::string& title, const std::vector<Curve>& curves, double height_mm,
                         bool whole = false);

}  // namespace voidpath::report
