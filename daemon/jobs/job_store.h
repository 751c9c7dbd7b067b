#pragma once

#include "daemon/jobs/database.h"
#include "daemon/jobs/job.h"
#include "engine/calibrate/correction.h"
#include "firmware-io/firmware_limits.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace voidpath::daemon {

/// What is kept of a printer between runs.
struct PrinterMemory {
  bool known = false;  ///< false: nothing was kept yet
  bool bed_clear = false;
  std::string held;
  std::string firmware;
  bool may_be_hot = false;  ///< a print began, and did not end with the printer's own heaters known to be off
};

/// How a printer's firmware last said it is set up, and which printer that was.
struct KeptLimits {
  std::string wiring;   ///< port and profile of the configuration: others may belong to another machine
  std::string machine;  ///< what the firmware called itself
  fw::FirmwareLimits limits;
};

struct LoggedEvent {
  std::int64_t id = 0;
  std::string at;
  std::string level;
  std::string text;
};

/// One correction as learned from the history.
struct LearnedFactor {
  std::string printer;
  std::string profile_sha256;
  std::string firmware;
  std::size_t observations = 0;
  std::optional<calibrate::Correction> correction;
};

/// Jobs, history and printers on disk. Loop thread only. Every function throws StoreError.
///
/// A crash at any point loses and doubles nothing: the input stays in its folder until its job has ended;
/// a row is committed before what it says is done (taken in, sent to the printer, filed), so that the
/// worst a crash leaves is a job that is said to be printing and never began, and that asks the user.
class JobStore {
 public:
  explicit JobStore(const std::filesystem::path& file);

  Transaction begin() { return Transaction(database_); }

  /// Takes the next place of its printer's queue and an id, both set in `job`.
  void insert(Job& job);
  void save(const Job& job);
  std::optional<Job> job(JobId id);
  /// Not ended, or ended and not yet filed; by position.
  std::vector<Job> open_jobs();

  PrinterMemory printer(const std::string& name);
  void save_printer(const std::string& name, const PrinterMemory& memory);
  std::optional<KeptLimits> limits(const std::string& printer);
  void save_limits(const std::string& printer, const KeptLimits& kept);
  void forget_limits(const std::string& printer);

  /// A record in state "open"; sets its id.
  void open_record(PrintRecord& record);
  /// Overwrites the record; one without id is added.
  void close_record(PrintRecord& record);
  /// The latest attempt of a job, open or ended.
  std::optional<PrintRecord> last_record_of(JobId job);
  /// Ended attempts, oldest first.
  std::vector<PrintRecord> history();

  /// Finished prints of the same printer, settings and firmware; newest first, at most `limit`.
  std::vector<calibrate::Observation> observations(const std::string& printer, const std::string& profile,
                                                   const std::string& firmware, int limit = 50);
  std::vector<LearnedFactor> learned();

  void log(const std::string& at, const std::string& level, const std::string& text);
  /// Events with an id above `after`, oldest first; at most the last `limit` of them.
  std::vector<LoggedEvent> events(std::int64_t after, int limit);

 private:
  Database database_;
  int logged_ = 0;
};

}  // namespace voidpath::daemon
