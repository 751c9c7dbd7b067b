#pragma once

#include "tests/mock_printer/firmware.h"
#include "tests/mock_printer/mock_marlin.h"
#include "tests/mock_printer/pty.h"
#include "tests/mock_printer/virtual_clock.h"

#include <atomic>
#include <memory>
#include <optional>
#include <string>

/// Joins firmware, pty, clock and log. One thread: the one that calls `run`.
namespace voidpath::test::mock {

struct RunnerOptions {
  std::string link{};
  double speed = 1;            ///< 0: as fast as it can
  double grace_s = 2;          ///< wall time an accelerated clock waits for a silent host
  std::string clock_file{};    ///< empty: none
  std::string log_file{};      ///< empty: none
  bool reset_on_open = false;  ///< a host that opens the port resets the printer, as boards with DTR do
};

/// What others ask of a running mock; safe from signal handlers and other threads.
struct RunnerRequests {
  std::atomic<bool> stop{false}, report{false}, reset{false};
};

class Runner {
 public:
  /// Opens pty, clock and log. Throws std::system_error.
  Runner(const Options& printer, const RunnerOptions& options);
  /// With any firmware.
  Runner(std::unique_ptr<Firmware> printer, const RunnerOptions& options);
  ~Runner();
  /// Until `requests.stop`. A report is one JSON line on stderr.
  void run(RunnerRequests& requests);
  const Firmware& printer() const { return *printer_; }

 private:
  void turn(double wall);
  void exchange();
  void let_time_pass(double wall);
  double patience() const;

  RunnerOptions options_;
  std::unique_ptr<Firmware> printer_;
  Pty pty_;
  Pacer pacer_;
  std::unique_ptr<ClockFile> clock_;
  int log_ = -1;
  std::string in_, out_;
  std::optional<double> plug_at_;
  double due_ = 0;  ///< printer time the clock may go to
};

/// The one-line report.
std::string to_json(const Statistics& statistics);

}  // namespace voidpath::test::mock
