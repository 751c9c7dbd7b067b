#pragma once

#include <string>

/// What a user wrote for one file, read the same way on the command line and in the interface.
namespace voidpath::daemon {

inline constexpr int kMaxCopies = 1000;  ///< as in the files beside models

/// All throw std::invalid_argument with a sentence.
std::string read_method(const std::string& text);
std::string read_slicer(const std::string& text);
int read_copies(const std::string& text);
double read_scale(const std::string& text);

}  // namespace voidpath::daemon
