#pragma once

#include "tests/mock_printer/line_protocol.h"
#include "tests/mock_printer/mock_marlin.h"

#include <string>
#include <string_view>
#include <vector>

/// A host for tests of the mock: numbers and sums lines, talks to a printer in memory.
namespace voidpath::test::mock {

inline std::string numbered(std::int64_t n, std::string_view command) {
  std::string line = "N" + std::to_string(n) + " " + std::string(command);
  return line + "*" + std::to_string(checksum_of(line)) + "\n";
}

inline std::size_t count_of(std::string_view text, std::string_view what) {
  std::size_t n = 0;
  for (auto at = text.find(what); at != text.npos; at = text.find(what, at + what.size())) ++n;
  return n;
}

/// Sends raw bytes and lets `seconds` pass; everything the printer said.
inline std::string say(MockMarlin& printer, std::string_view bytes, double seconds = 0) {
  printer.feed(bytes);
  printer.advance_to(printer.now() + seconds);
  return printer.take_output();
}

/// Sends an unnumbered command and waits for its ok; what was said meanwhile. Stops at `limit` s.
inline std::string run(MockMarlin& printer, std::string_view command, double limit = 1e6) {
  const double end = printer.now() + limit;
  std::string heard = say(printer, std::string(command) + "\n");
  while (heard.find("ok") == heard.npos && printer.next_event() <= end) {
    printer.advance_to(printer.next_event());
    heard += printer.take_output();
  }
  return heard;
}

/// A printer past its greeting, with the log of what it executed.
struct Rig {
  explicit Rig(const Options& options = make_mock().cold_extrusion().build()) : printer(options) {
    printer.on_command([this](std::string_view c) { log.emplace_back(c); });
    greeting = printer.take_output();
  }
  std::vector<std::string> log;
  MockMarlin printer;
  std::string greeting;
};

}  // namespace voidpath::test::mock
