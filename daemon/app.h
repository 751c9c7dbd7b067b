#pragma once

#include "config/config.h"

#include <memory>

namespace voidpath::daemon {

/// The whole daemon: composed in order, torn down in the reverse one. Call block_signals() before.
class App {
 public:
  /// Throws config::ConfigError, StoreError, ListenError, std::system_error, std::runtime_error: then
  /// nothing was started.
  explicit App(config::DaemonConfig config);
  ~App();
  App(const App&) = delete;
  App& operator=(const App&) = delete;

  /// Until SIGTERM or SIGINT; a second one ends it at once. Running prints are ended safely.
  void run();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Watched folders and state_dir as absolute paths without trailing slashes, so that they compare.
config::DaemonConfig with_plain_paths(config::DaemonConfig config);

/// Loads every printer's profile and what else only shows at use. Throws config::ConfigError.
void check_config(const config::DaemonConfig& config);

}  // namespace voidpath::daemon
