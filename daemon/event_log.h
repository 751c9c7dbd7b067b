#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace voidpath::daemon {

/// UTC, ISO 8601, to the second.
std::string utc_now();

/// What happened, as one line of key=value pairs with stable keys: to stderr (the journal) and to the
/// store's list of recent events. Loop thread only.
class EventLog {
 public:
  enum class Level { info, warning, error };
  using Fields = std::vector<std::pair<std::string_view, std::string>>;
  using Sink = std::function<void(const std::string& at, const std::string& level, const std::string& text)>;

  /// `sink` keeps the line; may be empty and may throw.
  explicit EventLog(Sink sink = {}, bool to_stderr = true) : sink_(std::move(sink)), stderr_(to_stderr) {}

  void info(std::string_view event, const Fields& fields = {}) { add(Level::info, event, fields); }
  void warning(std::string_view event, const Fields& fields = {}) { add(Level::warning, event, fields); }
  void error(std::string_view event, const Fields& fields = {}) { add(Level::error, event, fields); }

 private:
  void add(Level level, std::string_view event, const Fields& fields) noexcept;
  Sink sink_;
  bool stderr_;
};

}  // namespace voidpath::daemon
