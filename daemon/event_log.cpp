#include "daemon/event_log.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>

namespace voidpath::daemon {
namespace {

void append_value(std::string& out, std::string_view value) {
  if (!value.empty() && value.find_first_of(" \"=\\\n\t") == std::string_view::npos) {
    out += value;
    return;
  }
  out += '"';
  for (const char c : value) {
    if (c == '"' || c == '\\') out += '\\';
    out += c == '\n' || c == '\r' || c == '\t' ? ' ' : c;
  }
  out += '"';
}

}  // namespace

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 32> buffer{};
  std::strftime(buffer.data(), buffer.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return buffer.data();
}

void EventLog::add(Level level, std::string_view event, const Fields& fields) noexcept try {
  static constexpr std::array<const char*, 3> kNames = {"info", "warning", "error"};
  static constexpr std::array<const char*, 3> kJournal = {"<6>", "<4>", "<3>"};
  const auto index = static_cast<std::size_t>(level);
  std::string line = "event=" + std::string(event);
  for (const auto& [key, value] : fields) {
    line += ' ';
    line += key;
    line += '=';
    append_value(line, value);
  }
  if (stderr_) {
    const char* prefix = std::getenv("JOURNAL_STREAM") != nullptr ? kJournal[index] : "";
    std::fprintf(stderr, "%slevel=%s %s\n", prefix, kNames[index], line.c_str());
  }
  if (sink_) sink_(utc_now(), kNames[index], line);
} catch (const std::exception& error) {
  std::fprintf(stderr, "level=error event=log_failed reason=\"%s\"\n", error.what());
}

}  // namespace voidpath::daemon
