#pragma once

namespace voidpath::daemon {

/// As in `voidpath --version`.
const char* version() noexcept;

}  // namespace voidpath::daemon
