#include "daemon/jobs/job_store.h"

#include "daemon/jobs/facts_json.h"
#include "daemon/jobs/limits_json.h"
#include "daemon/jobs/schema.h"

#include <cmath>
#include <utility>

namespace voidpath::daemon {
namespace {

constexpr int kSchemaVersion = 2;
/// From this one on a print's record tells of doubts.
constexpr int kSchemaWithDoubts = 2;
/// Events kept; older ones go.
constexpr int kKeptEvents = 5000;
/// How often old events are dropped, in events.
constexpr int kPruneEvery = 500;

constexpr const char* kJobColumns =
    "id, printer, folder, input, location, device, inode, size, mtime_ns, state, position, copies, "
    "copies_done, options, facts, message, filed, received";
constexpr const char* kPrintColumns =
    "id, job, file, started, ended, state, reason, printer, firmware, measured_s, heating_s, paused_s, "
    "total_s, resends, layer_s, facts, doubts";

Job read_job(const Statement& row) {
  Job job;
  job.id = row.integer(0);
  job.printer = row.text(1);
  job.folder = row.text(2);
  job.input = row.text(3);
  job.location = row.text(4);
  job.file.device = static_cast<std::uint64_t>(row.integer(5));
  job.file.inode = static_cast<std::uint64_t>(row.integer(6));
  job.file.size = static_cast<std::uint64_t>(row.integer(7));
  job.file.mtime_ns = row.integer(8);
  const auto state = state_from(row.text(9));
  if (!state) throw StoreError("job " + std::to_string(job.id) + " has the unknown state " + row.text(9));
  job.state = *state;
  job.position = row.integer(10);
  job.copies = static_cast<int>(row.integer(11));
  job.copies_done = static_cast<int>(row.integer(12));
  job.options = options_from(row.text(13));
  job.facts = facts_from(row.text(14));
  job.message = row.text(15);
  job.filed = row.integer(16) != 0;
  job.received = row.text(17);
  return job;
}

PrintRecord read_record(const Statement& row) {
  PrintRecord record;
  record.id = row.integer(0);
  record.job = row.integer(1);
  record.file = row.text(2);
  record.started = row.text(3);
  record.ended = row.text(4);
  record.state = row.text(5);
  record.reason = row.text(6);
  record.printer = row.text(7);
  record.firmware = row.text(8);
  record.measured_s = row.maybe_real(9);
  record.heating_s = row.real(10);
  record.paused_s = row.real(11);
  record.total_s = row.maybe_real(12);
  record.resends = static_cast<std::uint64_t>(row.integer(13));
  record.layer_measured_s = numbers_from(row.text(14));
  record.facts = facts_from(row.text(15));
  record.doubts = static_cast<std::uint64_t>(row.integer(16));
  return record;
}

void bind_job(Statement& row, const Job& job) {
  row.bind(job.printer).bind(job.folder.string()).bind(job.input.string()).bind(job.location.string());
  row.bind(static_cast<std::int64_t>(job.file.device)).bind(static_cast<std::int64_t>(job.file.inode));
  row.bind(static_cast<std::int64_t>(job.file.size)).bind(job.file.mtime_ns);
  row.bind(name_of(job.state)).bind(job.position).bind(std::int64_t{job.copies});
  row.bind(std::int64_t{job.copies_done}).bind(to_text(job.options)).bind(to_text(job.facts));
  row.bind(job.message).bind(std::int64_t{job.filed}).bind(job.received);
}

void bind_record(Statement& row, const PrintRecord& record) {
  row.bind(record.job).bind(record.file).bind(record.started).bind(record.ended).bind(record.state);
  row.bind(record.reason).bind(record.printer).bind(record.firmware).bind(record.facts.profile_sha256);
  row.bind(record.facts.predicted_raw_s).bind(record.measured_s).bind(record.heating_s);
  row.bind(record.paused_s).bind(record.total_s).bind(static_cast<std::int64_t>(record.resends));
  row.bind(to_text(record.layer_measured_s)).bind(to_text(record.facts));
  row.bind(static_cast<std::int64_t>(record.doubts));
}

}  // namespace

JobStore::JobStore(const std::filesystem::path& file) : database_(file) {
  auto version = database_.prepare("PRAGMA user_version");
  version.step();
  const auto found = version.integer(0);
  version.run();
  if (found > kSchemaVersion) {
    throw StoreError(file.string() + " was written by a newer voidpathd (schema " + std::to_string(found) +
                     "); use that one, or another state_dir");
  }
  Transaction change(database_);
  database_.execute(kSchema);
  if (found > 0 && found < kSchemaWithDoubts)
    database_.execute("ALTER TABLE prints ADD COLUMN doubts INTEGER NOT NULL DEFAULT 0");
  database_.execute(("PRAGMA user_version=" + std::to_string(kSchemaVersion)).c_str());
  change.commit();
}

void JobStore::insert(Job& job) {
  auto last = database_.prepare("SELECT coalesce(max(position), 0) FROM jobs WHERE printer = ?");
  last.bind(job.printer).step();
  job.position = last.integer(0) + 1;
  auto row = database_.prepare(
      "INSERT INTO jobs (printer, folder, input, location, device, inode, size, mtime_ns, state, position, "
      "copies, copies_done, options, facts, message, filed, received) "
      "VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)");
  bind_job(row, job);
  row.run();
  job.id = database_.last_id();
}

void JobStore::save(const Job& job) {
  auto row = database_.prepare(
      "UPDATE jobs SET printer=?, folder=?, input=?, location=?, device=?, inode=?, size=?, mtime_ns=?, "
      "state=?, position=?, copies=?, copies_done=?, options=?, facts=?, message=?, filed=?, received=? "
      "WHERE id=?");
  bind_job(row, job);
  row.bind(job.id).run();
}

std::optional<Job> JobStore::job(JobId id) {
  auto row = database_.prepare(std::string("SELECT ") + kJobColumns + " FROM jobs WHERE id = ?");
  row.bind(id);
  if (!row.step()) return std::nullopt;
  return read_job(row);
}

std::vector<Job> JobStore::open_jobs() {
  auto row = database_.prepare(std::string("SELECT ") + kJobColumns +
                               " FROM jobs WHERE filed = 0 OR state NOT IN ('done','failed','cancelled') "
                               "ORDER BY position, id");
  std::vector<Job> out;
  while (row.step()) out.push_back(read_job(row));
  return out;
}

PrinterMemory JobStore::printer(const std::string& name) {
  auto row = database_.prepare("SELECT bed_clear, held, firmware, may_be_hot FROM printers WHERE name = ?");
  row.bind(name);
  if (!row.step()) return {};
  return {true, row.integer(0) != 0, row.text(1), row.text(2), row.integer(3) != 0};
}

void JobStore::save_printer(const std::string& name, const PrinterMemory& memory) {
  database_
      .prepare(
          "INSERT OR REPLACE INTO printers (name, bed_clear, held, firmware, may_be_hot) VALUES (?,?,?,?,?)")
      .bind(name)
      .bind(std::int64_t{memory.bed_clear})
      .bind(memory.held)
      .bind(memory.firmware)
      .bind(std::int64_t{memory.may_be_hot})
      .run();
}

std::optional<KeptLimits> JobStore::limits(const std::string& printer) {
  auto row = database_.prepare("SELECT wiring, machine, limits FROM printer_limits WHERE name = ?");
  row.bind(printer);
  if (!row.step()) return std::nullopt;
  return KeptLimits{row.text(0), row.text(1), limits_from(row.text(2))};
}

void JobStore::save_limits(const std::string& printer, const KeptLimits& kept) {
  database_.prepare("INSERT OR REPLACE INTO printer_limits (name, wiring, machine, limits) VALUES (?,?,?,?)")
      .bind(printer)
      .bind(kept.wiring)
      .bind(kept.machine)
      .bind(to_text(kept.limits))
      .run();
}

void JobStore::forget_limits(const std::string& printer) {
  database_.prepare("DELETE FROM printer_limits WHERE name = ?").bind(printer).run();
}

void JobStore::open_record(PrintRecord& record) {
  record.state = "open";
  record.id = 0;
  close_record(record);
}

void JobStore::close_record(PrintRecord& record) {
  if (record.id == 0) {
    auto row = database_.prepare(
        "INSERT INTO prints (job, file, started, ended, state, reason, printer, firmware, profile_sha256, "
        "predicted_raw_s, measured_s, heating_s, paused_s, total_s, resends, layer_s, facts, doubts) "
        "VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)");
    bind_record(row, record);
    row.run();
    record.id = database_.last_id();
    return;
  }
  auto row = database_.prepare(
      "UPDATE prints SET job=?, file=?, started=?, ended=?, state=?, reason=?, printer=?, firmware=?, "
      "profile_sha256=?, predicted_raw_s=?, measured_s=?, heating_s=?, paused_s=?, total_s=?, resends=?, "
      "layer_s=?, facts=?, doubts=? WHERE id=?");
  bind_record(row, record);
  row.bind(record.id).run();
}

std::optional<PrintRecord> JobStore::last_record_of(JobId job) {
  auto row = database_.prepare(std::string("SELECT ") + kPrintColumns +
                               " FROM prints WHERE job = ? ORDER BY id DESC LIMIT 1");
  row.bind(job);
  if (!row.step()) return std::nullopt;
  return read_record(row);
}

std::vector<PrintRecord> JobStore::history() {
  auto row = database_.prepare(std::string("SELECT ") + kPrintColumns +
                               " FROM prints WHERE state <> 'open' ORDER BY id");
  std::vector<PrintRecord> out;
  while (row.step()) out.push_back(read_record(row));
  return out;
}

std::vector<calibrate::Observation> JobStore::observations(const std::string& printer,
                                                           const std::string& profile,
                                                           const std::string& firmware, int limit) {
  auto row = database_.prepare(
      "SELECT predicted_raw_s, measured_s FROM prints WHERE state = 'done' AND printer = ? AND "
      "profile_sha256 = ? AND firmware = ? AND measured_s IS NOT NULL ORDER BY id DESC LIMIT ?");
  row.bind(printer).bind(profile).bind(firmware).bind(std::int64_t{limit});
  std::vector<calibrate::Observation> out;
  while (row.step()) out.push_back({row.real(0), row.real(1)});
  return out;
}

std::vector<LearnedFactor> JobStore::learned() {
  std::vector<LearnedFactor> out;
  auto row = database_.prepare(
      "SELECT DISTINCT printer, profile_sha256, firmware FROM prints WHERE state = 'done' "
      "ORDER BY printer, profile_sha256, firmware");
  while (row.step()) out.push_back({row.text(0), row.text(1), row.text(2), 0, std::nullopt});
  for (auto& entry : out) {
    const auto rows = observations(entry.printer, entry.profile_sha256, entry.firmware);
    entry.observations = rows.size();
    entry.correction = calibrate::fit_correction(rows);
  }
  return out;
}

void JobStore::log(const std::string& at, const std::string& level, const std::string& text) {
  database_.prepare("INSERT INTO events (at, level, text) VALUES (?,?,?)")
      .bind(at)
      .bind(level)
      .bind(text)
      .run();
  if (++logged_ % kPruneEvery != 0) return;
  database_.prepare("DELETE FROM events WHERE id <= (SELECT max(id) FROM events) - ?")
      .bind(std::int64_t{kKeptEvents})
      .run();
}

std::vector<LoggedEvent> JobStore::events(std::int64_t after, int limit) {
  auto row = database_.prepare(
      "SELECT id, at, level, text FROM (SELECT * FROM events WHERE id > ? ORDER BY id DESC LIMIT ?) "
      "ORDER BY id");
  row.bind(after).bind(std::int64_t{limit});
  std::vector<LoggedEvent> out;
  while (row.step()) out.push_back({row.integer(0), row.text(1), row.text(2), row.text(3)});
  return out;
}

}  // namespace voidpath::daemon
