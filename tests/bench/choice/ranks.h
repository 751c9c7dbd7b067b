#pragma once

#include <optional>
#include <string>
#include <vector>

namespace voidpath::bench {

/// Spearman's rank correlation; equal values share their mean rank. Nothing for fewer than three pairs or
/// where one side has no order.
std::optional<double> spearman(const std::vector<double>& a, const std::vector<double>& b);

/// Seconds from "1d 2h 3m 4s", any of them missing; nothing where there is no such thing.
std::optional<double> seconds_of(const std::string& text);

/// PrusaSlicer's own estimate (normal mode), from its G-code's comments.
std::optional<double> rival_estimate(const std::string& gcode_file);

}  // namespace voidpath::bench
