#pragma once

#include <string_view>

namespace voidpath::report {

/// The page's style sheet; without characters that XML would want escaped.
std::string_view style();

}  // namespace voidpath::report
