#pragma once

#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/e2e/process.h"

namespace voidpath::test {

/// A mock printer and a daemon around it, in a scratch folder, driven through the command line alone.
class BenchRig {
 public:
  struct Options {
    bool auto_clear = true;
    std::string mock_speed = "0";
    std::string faults = "";        ///< text of a fault script; empty: none
    std::string extra_config = "";  ///< top-level lines
    std::string profile = "generic-marlin";
    std::vector<std::string> mock_args = {};
    std::string port = "tty";  ///< below the scratch folder
  };
  BenchRig() : BenchRig(Options{}) {}
  explicit BenchRig(Options options);

  /// With its port at `link`, below the scratch folder.
  void start_mock(const std::string& link = "tty");
  /// Waits until it answers.
  void start_daemon();
  void kill_daemon();
  /// SIGTERM and wait; returns the exit code.
  int stop_daemon();

  /// voidpath ARGS with this rig's configuration.
  Result cli(std::vector<std::string> args, double limit_s = 120);
  nlohmann::json cli_json(std::vector<std::string> args);
  nlohmann::json history() { return cli_json({"history", "--json"}); }
  nlohmann::json status() { return cli_json({"status", "--json"}); }
  /// Waits until the history holds `rows` rows in a final state.
  bool wait_for_history(std::size_t rows, double limit_s = 120);

  /// Commands the mock executed, without those the host sends of its own: handshake, temperature polling,
  /// the closing M400.
  std::vector<std::string> executed_print_lines() const;
  std::vector<std::string> executed_lines() const;
  /// The mock's own count, as its SIGUSR1 line says.
  nlohmann::json mock_counts();

  const std::filesystem::path& dir() const { return scratch_.path(); }
  std::filesystem::path inbox() const { return scratch_ / "inbox"; }
  Process& daemon() { return *daemon_; }
  Process& mock() { return *mock_; }

 private:
  ScratchDir scratch_;
  Options options_;
  std::string listen_;
  std::unique_ptr<Process> mock_;
  std::unique_ptr<Process> daemon_;
};

std::string program(const std::string& name);
/// A G-code file's commands as a host sends them: no comments, no blanks.
std::vector<std::string> commands_of(const std::filesystem::path& gcode);

}  // namespace voidpath::test
