#pragma once

#include <string_view>
#include <vector>

namespace voidpath::fw {

/// The lines of a text, whatever ends them, without empty ones.
std::vector<std::string_view> lines_of(std::string_view text);

}  // namespace voidpath::fw
