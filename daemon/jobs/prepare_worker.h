#pragma once

#include "config/config.h"
#include "daemon/executor.h"
#include "daemon/jobs/job.h"
#include "engine/run/context.h"
#include "firmware-io/firmware_limits.h"
#include "firmware-io/s3g/machine.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace voidpath::daemon {

/// Everything a job needs to be prepared, copied so that the worker shares nothing.
struct PrepareTask {
  JobId job = 0;
  std::filesystem::path input;
  FileId file;
  JobOptions options;
  std::filesystem::path folder;     ///< whose override file counts
  std::filesystem::path gcode_out;  ///< its folder exists or is made
  config::PrinterConfig printer;
  /// As the printer told at its last connection; nothing: the profile's word counts.
  std::optional<fw::FirmwareLimits> firmware;
  std::optional<fw::s3g::Machine> s3g;  ///< of a MakerBot: what it would refuse in mid-print fails here
  config::OrientConfig orient;
  config::SlicerConfig slicer;
};

struct PrepareResult {
  enum class Kind {
    prepared,
    failed,     ///< message says why, for the user
    unsettled,  ///< the input changed meanwhile or is not complete yet: wait for it and try again
    stopped,
  } kind = Kind::failed;
  std::string message;
  JobFacts facts;
  int copies = 1;
  std::vector<std::string> slicer_messages;  ///< of a slicer that is not ours, for the events
};

using PrepareFunction = std::function<PrepareResult(const PrepareTask&, const run::Context&)>;

/// The real work: hashes, applies overrides and profile, runs the engine (or only times a ready G-code
/// file), leaves the G-code at gcode_out. Never throws; any thread.
PrepareResult prepare_input(const PrepareTask& task, const run::Context& ctx);

/// One thread that prepares one job at a time. It never touches store or state: results and progress are
/// posted to the loop. All members: loop thread.
class PrepareWorker {
 public:
  using Done = std::function<void(JobId, PrepareResult)>;
  using Progress = std::function<void(JobId, std::string phase, double fraction)>;

  PrepareWorker(Executor& loop, PrepareFunction work, Done done, Progress progress);
  /// Stops what runs and waits for it.
  ~PrepareWorker();

  bool busy() const noexcept { return busy_; }
  /// Only while not busy.
  void start(PrepareTask task);
  /// Asks the running one to stop; its result comes as `stopped`, or as what it ended with.
  void stop() noexcept { stop_.request_stop(); }

 private:
  Executor& loop_;
  PrepareFunction work_;
  Done done_;
  Progress progress_;
  bool busy_ = false;
  std::stop_source stop_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  ///< read and written on the loop only
  std::jthread thread_;
};

}  // namespace voidpath::daemon
