#pragma once

#include "engine/evaluate/compare.h"

#include <optional>
#include <string>
#include <vector>

namespace voidpath::evaluate {

/// Times this near, as a share, are the same: what the planner is good for.
inline constexpr double kSame = 1e-3;

/// Two methods' times over the models that have both.
struct Pair {
  std::vector<double> ratios;  ///< time(a) / time(b)
  std::vector<std::string> models;
};
Pair compare_methods(const std::vector<Row>& rows, const std::string& a, const std::string& b);

struct Shares {
  std::size_t count = 0;
  double equal = 0;
  double above = 0;  ///< ratios above 1
  double below = 0;
};
Shares shares_of(const std::vector<double>& ratios);

/// Linear between the values; `q` from 0 to 1. There must be values.
double quantile(std::vector<double> values, double q);

/// The models, in the order of the rows, and one method's row of a model.
std::vector<std::string> models_of(const std::vector<Row>& rows);
const Row* find_row(const std::vector<Row>& rows, const std::string& model, const std::string& method);

/// The key figures in a few lines of plain text: the published experiment, and what the default method gains
/// and loses.
std::string summary_text(const std::vector<Row>& rows);

}  // namespace voidpath::evaluate
