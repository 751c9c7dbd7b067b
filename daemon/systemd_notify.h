#pragma once

#include <optional>
#include <string>

namespace voidpath::daemon {

/// Tells the service manager, if there is one: "READY=1", "STATUS=...", "WATCHDOG=1", "STOPPING=1"; lines
/// may be joined by '\n'. Silent where $NOTIFY_SOCKET is not set. Never blocks or throws.
void notify_manager(const std::string& state) noexcept;

/// The time within which the manager wants to hear WATCHDOG=1, s; empty: it does not watch this process.
std::optional<double> watchdog_period_s() noexcept;

}  // namespace voidpath::daemon
