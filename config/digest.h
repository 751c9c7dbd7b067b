#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace voidpath::config {

/// SHA-256 in lower-case hex. Throws std::runtime_error naming the file when it cannot be read.
std::string sha256_of(std::string_view bytes);
std::string sha256_of_file(const std::filesystem::path& file);

}  // namespace voidpath::config
