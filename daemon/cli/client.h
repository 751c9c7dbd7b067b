#pragma once

#include "daemon/json/json.h"

#include <cstdio>
#include <string>
#include <vector>

/// The command line as a client of the daemon.
namespace voidpath::cli {

inline constexpr int kFailed = 1;
inline constexpr int kUsage = 2;
inline constexpr int kRefused = 3;
inline constexpr int kUnreachable = 4;

bool is_client(const std::string& command);
/// Runs it; returns the exit code. Errors go to stderr.
int run_client(const std::string& command, const std::vector<std::string>& args);

/// Ends a command with an exit code; what() goes to stderr.
class ClientError : public std::runtime_error {
 public:
  ClientError(int code, const std::string& what) : std::runtime_error(what), code_(code) {}
  int code() const noexcept { return code_; }

 private:
  int code_;
};

/// Flags that every client command knows, and what is left of the line.
struct ClientFlags {
  std::string config;
  std::string host;
  std::string printer;
  bool json = false;
  bool csv = false;
  bool follow = false;
  bool as_delivered = false;
  std::string method;
  std::string slicer;
  int copies = 0;
  double scale = 0;
  std::vector<std::string> rest;
};
/// Throws ClientError(kUsage).
ClientFlags parse_client(const std::string& command, const std::vector<std::string>& args);
/// A job number. Throws ClientError(kUsage).
std::int64_t parse_job(const std::string& text);

/// Speaks to the daemon; throws ClientError: kUnreachable, or kFailed with the daemon's words.
class DaemonClient {
 public:
  explicit DaemonClient(const ClientFlags& flags);
  daemon::Json get(const std::string& what) const;
  std::string get_text(const std::string& what) const;
  daemon::Json command(const std::string& name, const daemon::Json& body) const;
  daemon::Json upload(const std::string& file, const ClientFlags& flags) const;

 private:
  std::string address_;
};

// Output for people.
void print_status(const daemon::Json& status);
void print_queue(const daemon::Json& queue);
void print_history(const daemon::Json& history);
void print_calibration(const daemon::Json& calibration);

int logs_command(const DaemonClient& client, const ClientFlags& flags);
int terminal_command(const DaemonClient& client, const ClientFlags& flags);
/// Shows what goes on until nothing does any more; for ever with --follow.
int watch_command(const DaemonClient& client, const ClientFlags& flags);

}  // namespace voidpath::cli
