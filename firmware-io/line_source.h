#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace voidpath::fw {

struct SourceLine {
  std::string text;         ///< one command without comment, line number or checksum
  std::uint32_t index = 0;  ///< 0-based line of the file it came from
};

/// Where a print's lines come from, pulled one by one by the session's thread alone.
class LineSource {
 public:
  virtual ~LineSource() = default;
  /// The next command; empty at the end. Comment-only and blank lines never appear.
  /// Throws std::runtime_error when the file cannot be read further.
  virtual std::optional<SourceLine> next() = 0;
  /// The same in place of `line`, whose memory it may use again; false at the end.
  virtual bool fetch(SourceLine& line) {
    std::optional<SourceLine> found = next();
    if (found) line = std::move(*found);
    return found.has_value();
  }
  /// Bytes of the file consumed so far and in all, for progress. Total may be 0 when unknown.
  virtual std::uint64_t position() const noexcept = 0;
  virtual std::uint64_t size() const noexcept = 0;
};

}  // namespace voidpath::fw
