#pragma once

#include "engine/evaluate/compare.h"

#include <string>
#include <string_view>
#include <vector>

namespace voidpath::evaluate {

/// Header and a line a row; numbers read back as they were.
std::string to_csv(const std::vector<Row>& rows);

/// What to_csv() wrote. Throws std::runtime_error naming the line.
std::vector<Row> from_csv(std::string_view text);

}  // namespace voidpath::evaluate
