#pragma once

#include <string>
#include <string_view>

namespace voidpath::test {

/// A G command with one blank before each of its words, however it went over the wire; others as they are.
inline std::string spaced(std::string_view command) {
  if (!command.starts_with('G')) return std::string(command);
  std::string out;
  for (const char c : command) {
    const bool letter = c >= 'A' && c <= 'Z';
    if (letter && !out.empty() && out.back() != ' ') out += ' ';
    out += c;
  }
  return out;
}

}  // namespace voidpath::test
