#pragma once

#include <string>

namespace voidpath::bench {

/// Prints the file through a PrinterPort and leaves when it is over: 0 when it was printed.
/// `window`: bytes that may be unacknowledged.
int print_file(const std::string& port, int baud, bool meatpack, const std::string& file, int window);

/// Starts the print and, `after_s` later, calls halt(); says on standard output when that was.
int stop_print(const std::string& port, int baud, const std::string& file, double after_s);

}  // namespace voidpath::bench
