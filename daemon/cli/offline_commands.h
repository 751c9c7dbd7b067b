#pragma once

#include <string>
#include <vector>

/// Commands that need neither daemon nor printer.
namespace voidpath::cli {

bool is_offline(const std::string& command);
/// Runs it; returns the exit code. Errors go to stderr.
int run_offline(const std::string& command, const std::vector<std::string>& args);

}  // namespace voidpath::cli
