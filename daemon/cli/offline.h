#pragma once

#include <string>
#include <vector>

#include "config/config.h"
#include "engine/pipeline/prepare.h"

/// What the offline commands share: their common flags, and settings made from them.
namespace voidpath::cli {

/// Wrong use of the command line: exit code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct CommonFlags {
  bool json = false;
  std::string config;
  std::string profile;
  double scale = 1.0;
  unsigned threads = 0;
  std::vector<std::string> set;  ///< key=value
};

struct OrientFlags {
  std::string method;
  std::string weights;
  int subdivisions = -1;
  std::string critical;
  double budget_s = -1;  ///< negative: the configuration's
};

/// Configuration file, profile and flags laid over one another.
/// Throws config::ConfigError, UsageError.
struct Settings {
  config::DaemonConfig daemon;
  config::Profile profile;
  pipeline::PrepareOptions options;
};
Settings settings_from(const CommonFlags& common, const OrientFlags& orient);

/// "1,0,0" and the like, as many numbers as wanted. Throws UsageError naming the flag.
std::vector<double> numbers_from(const std::string& flag, const std::string& text, std::size_t count);
/// "key=value" pairs. Throws UsageError.
std::vector<std::pair<std::string, std::string>> pairs_from(const std::vector<std::string>& set);

/// A context that draws a progress line on stderr when that is a terminal.
run::Context console_context(unsigned threads);
/// Wipes the progress line.
void end_progress();

/// "1 h 02 min", "3 min 20 s", "12.3 s".
std::string duration_text(double seconds);
std::string fixed(double value, int decimals);

int orient_command(const std::vector<std::string>& args);
int slice_command(const std::vector<std::string>& args);
int estimate_command(const std::vector<std::string>& args);
int check_command(const std::vector<std::string>& args);
int evaluate_command(const std::vector<std::string>& args);
int weights_command(const std::vector<std::string>& args);
int profile_command(const std::vector<std::string>& args);

}  // namespace voidpath::cli
