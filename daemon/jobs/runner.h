#pragma once

#include "config/config.h"
#include "daemon/event_log.h"
#include "daemon/executor.h"
#include "daemon/intake/settle.h"
#include "daemon/jobs/job_store.h"
#include "daemon/jobs/prepare_worker.h"
#include "daemon/jobs/printer.h"
#include "daemon/jobs/transitions.h"

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace voidpath::daemon {

/// A command that cannot be done as things stand; what() says why and what to do instead.
class CommandError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Performs what the table of transitions says: keeps jobs in the store, hands them to the worker and the
/// printers, files inputs. Each step is committed before its effect. Loop thread only.
class Runner {
 public:
  struct Services {
    Executor& loop;
    JobStore& store;
    Settler& settler;
    EventLog& log;
    PrepareFunction prepare;
    PortServices port;
    /// What the session of a printer is opened with; may throw config::ConfigError.
    std::function<fw::PortOptions(const config::PrinterConfig&)> port_options;
    /// Where pins come from; only for printers that have some.
    fw::Pins* pins = nullptr;
  };

  /// Throws fw::PinError where a configured pin cannot be had.
  Runner(Services services, config::DaemonConfig config);
  ~Runner();
  Runner(const Runner&) = delete;
  Runner& operator=(const Runner&) = delete;

  /// Takes up what the last run left, then opens the printers. Once, before anything else.
  void start();
  /// Ends running prints safely; `finished` is called once when they have ended, or after a while.
  void shutdown(std::function<void()> finished);

  /// A file has settled in a watched folder.
  void take(const StableFile& file);
  /// Whether the file, as it is, belongs to a job already.
  bool owns(const std::filesystem::path& file, const FileId& id) const;

  // Commands. Each throws CommandError and StoreError.
  void pause(const std::string& printer);
  void resume(const std::string& printer);
  /// Empty: what is on the printer.
  void cancel(std::optional<JobId> job, const std::string& printer);
  void bed_clear(const std::string& printer);
  void retry(JobId job);
  void resume_interrupted(JobId job);
  void discard(JobId job);
  void move(JobId job, std::int64_t place);  ///< 1 is the first of the queue
  void command_line(const std::string& printer, const std::string& line);
  void power(const std::string& printer, bool on);
  void light(const std::string& printer, bool on);
  /// After the ports have been halted: fails what was printing and holds the queue. Empty: all printers.
  void halted(const std::string& printer, const std::string& reason);
  /// Puts `upload` (a complete file in the printer's first watched folder) in the queue under `name`.
  JobId add(const std::filesystem::path& upload, const std::string& name, const JobOptions& options,
            const std::string& printer);

  /// Not ended, by printer and position.
  std::vector<const Job*> queue() const;
  const std::vector<std::unique_ptr<Printer>>& printers() const noexcept { return printers_; }
  /// By name; the only one for an empty name. Throws CommandError.
  Printer& printer(const std::string& name);
  /// Why the printer does not start its next job, for the user; empty when it prints or has nothing to do.
  std::string waiting_reason(const Printer& printer) const;
  const Job* job_on(const Printer& printer) const;
  JobStore& store() noexcept { return s_.store; }
  /// Changes with every change of what users see.
  std::uint64_t revision() const noexcept { return revision_; }
  struct Preparing {
    JobId job = 0;
    std::string phase;
    double fraction = 0;
  };
  const Preparing& preparing() const noexcept { return preparing_; }

 private:
  /// May be repeated long after its call: captures by value.
  using Edit = std::function<void(Job&)>;
  /// Commits the transition, then performs its effects. False if the event has no meaning there.
  bool apply(JobId id, Event event, const Edit& edit = {});
  /// apply() for what happened by itself: where the store fails, it is tried again later.
  void happen(JobId id, Event event, const Edit& edit = {});
  /// apply() for what is decided by how things stand: where the store fails, it is decided anew later.
  void decide(JobId id, Event event, const Edit& edit = {});
  /// Keeps what is known of a printer; where the store fails, it is tried again later.
  void save_memory(Printer& printer);
  void commit(const Job& before, Job& after, const Transition& step);
  void end_record(const Job& before, const Job& after, Printer* printer, bool needed);
  void perform(JobId id, const Transition& step);
  void start_print(const Job& job);
  void file(Job& job, const char* subfolder);
  /// Gives an upload that is in the store the name its user knows.
  void show_upload(Job& job);
  void drop_stray_uploads() const;

  void on_printer_event(Printer& printer, const fw::Event& event);
  void compare_limits(Printer& printer);
  void recall_limits(Printer& printer);
  void keep_limits(Printer& printer);
  void on_print_end(Printer& printer, const fw::Event& event);
  void on_prepared(JobId id, PrepareResult result);
  void correct(const Job& job, JobFacts& facts);

  void attach_pins(Printer& printer);
  void update_pins(Printer& printer);
  void pins_of_event(Printer& printer, const fw::Event& event);
  void pause_by_pin(Printer& printer, const std::string& reason);
  bool about_to_print(const Printer& printer) const;

  void want_schedule();
  void schedule();
  void schedule_printer(Printer& printer);
  void schedule_prepare();

  Job& open_job(JobId id);  ///< loads an ended one from the store; throws CommandError
  void require(bool applied, const Job& job, const std::string& wish) const;
  std::vector<Job*> queue_of(const std::string& printer);
  Printer* find_printer(const std::string& name) const;
  const config::PrinterConfig* printer_of_folder(const std::filesystem::path& folder) const;
  std::filesystem::path gcode_of(JobId id) const;
  void changed() noexcept { ++revision_; }
  void check_shutdown();

  Services s_;
  config::DaemonConfig config_;
  std::map<JobId, Job> jobs_;  ///< all that are not ended and filed
  std::vector<std::unique_ptr<Printer>> printers_;
  /// What was measured of prints that have ended, until the store has it.
  std::map<JobId, PrintRecord> ended_records_;
  Preparing preparing_;
  std::unique_ptr<PrepareWorker> worker_;
  bool schedule_posted_ = false;
  bool stopping_ = false;
  std::function<void()> finished_;
  std::uint64_t revision_ = 1;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
};

}  // namespace voidpath::daemon
