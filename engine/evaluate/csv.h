#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace voidpath::evaluate {

struct CsvRow {
  std::vector<std::string> cells;
  std::size_t line = 1;  ///< the one it begins in, 1-based
};

/// Comma-separated values (RFC 4180): quotes may hold commas, line ends and doubled quotes; lines end with LF
/// or CRLF; empty lines and a byte order mark are passed over.
std::vector<CsvRow> parse_csv(std::string_view text);

/// A cell, in quotes where it needs them.
std::string csv_cell(std::string_view text);

}  // namespace voidpath::evaluate
