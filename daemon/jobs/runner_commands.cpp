#include "daemon/jobs/filing.h"
#include "daemon/jobs/runner.h"
#include "firmware-io/lines_of.h"
#include "firmware-io/marlin/codec.h"
#include "firmware-io/marlin/words.h"

#include <algorithm>
#include <system_error>

/// What users ask for.
namespace voidpath::daemon {

namespace fs = std::filesystem;

namespace {

bool is_emergency_stop(const std::string& text) {
  const auto lines = fw::lines_of(text);
  return std::any_of(lines.begin(), lines.end(), [](std::string_view line) {
    return fw::marlin::first_word(fw::marlin::sanitise(line)) == fw::marlin::Word{'M', 112};
  });
}

}  // namespace

Printer& Runner::printer(const std::string& name) {
  if (name.empty()) {
    if (printers_.size() == 1) return *printers_.front();
    throw CommandError(printers_.empty() ? "no printer is configured" : "say which printer: --printer NAME");
  }
  if (Printer* found = find_printer(name)) return *found;
  throw CommandError("there is no printer " + name);
}

Job& Runner::open_job(JobId id) {
  if (const auto found = jobs_.find(id); found != jobs_.end()) return found->second;
  auto stored = s_.store.job(id);
  if (!stored) throw CommandError("there is no job " + std::to_string(id));
  return jobs_.emplace(id, std::move(*stored)).first->second;
}

void Runner::require(bool applied, const Job& job, const std::string& wish) const {
  if (applied) return;
  throw CommandError("job " + std::to_string(job.id) + " (" + job.file_name() + ") is " +
                     std::string(name_of(job.state)) + ": it cannot be " + wish);
}

void Runner::pause(const std::string& name) {
  const Job* job = job_on(printer(name));
  if (job == nullptr) throw CommandError("nothing is being printed");
  require(apply(job->id, Event::pause), *job, "paused");
}

void Runner::resume(const std::string& name) {
  const Job* job = job_on(printer(name));
  if (job == nullptr) throw CommandError("nothing is being printed");
  if (const auto* pins = printer(name).pins(); pins != nullptr && !pins->blocker().empty())
    throw CommandError(pins->blocker() + ": see to that first");
  require(apply(job->id, Event::resume), *job, "resumed");
}

void Runner::cancel(std::optional<JobId> id, const std::string& name) {
  if (!id) {
    const Job* current = job_on(printer(name));
    if (current == nullptr)
      throw CommandError("nothing is being printed; `voidpath cancel JOB` takes one out of the queue");
    id = current->id;
  }
  if (const auto found = jobs_.find(*id); found == jobs_.end()) {
    const auto stored = s_.store.job(*id);
    if (!stored) throw CommandError("there is no job " + std::to_string(*id));
    require(stored->state == State::cancelled, *stored, "cancelled");
    return;
  }
  const Job job = jobs_.at(*id);
  require(apply(*id, Event::cancel, [](Job& j) { j.message = "cancelled by the user"; }), job, "cancelled");
}

void Runner::bed_clear(const std::string& name) {
  Printer& one = printer(name);
  if (job_on(one) || one.busy()) throw CommandError("the printer is at work: the bed is not clear");
  if (one.pins() && one.pins()->stop_pulled())
    throw CommandError("the emergency stop is pulled: let it go first");
  PrinterMemory memory = one.memory;
  memory.bed_clear = true;
  memory.held.clear();
  s_.store.save_printer(one.name(), memory);
  one.memory = memory;
  one.forget_halt();
  if (one.pins()) one.pins()->acknowledge();
  s_.log.info("bed_clear", {{"printer", one.name()}});
  changed();
  want_schedule();
}

void Runner::retry(JobId id) {
  const Job job = open_job(id);
  if (ended(job.state) && identify(job.location) != job.file) {
    jobs_.erase(id);
    throw CommandError("the file of job " + std::to_string(id) + " is no longer at " + job.location.string() +
                       ": drop it in the folder again");
  }
  const bool applied = apply(id, Event::retry, [](Job& j) {
    j.filed = false;
    j.copies_done = 0;
    j.message = "printed again at the user's wish";
  });
  if (!applied && job.filed) jobs_.erase(id);
  require(applied, job, "tried again");
}

void Runner::resume_interrupted(JobId id) {
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) throw CommandError("job " + std::to_string(id) + " is not interrupted");
  const Job job = found->second;
  const bool prepared = fs::exists(gcode_of(id));
  const auto begin_again = [](Job& j) {
    j.message = "printed again from its beginning after an interruption";
  };
  require(apply(id, prepared ? Event::resume_interrupted : Event::retry, begin_again), job, "resumed");
}

void Runner::discard(JobId id) {
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) throw CommandError("job " + std::to_string(id) + " is not interrupted");
  const Job job = found->second;
  const auto edit = [](Job& j) { j.message = "discarded by the user after an interruption"; };
  require(apply(id, Event::discard, edit), job,
          "discarded: that is for interrupted ones; use `voidpath cancel`");
}

void Runner::move(JobId id, std::int64_t place) {
  const auto found = jobs_.find(id);
  if (found == jobs_.end() || !queued(found->second.state)) {
    throw CommandError("job " + std::to_string(id) + " is not in the queue");
  }
  auto queue = queue_of(found->second.printer);
  std::vector<std::int64_t> positions;
  for (const Job* job : queue) positions.push_back(job->position);
  std::erase_if(queue, [&](const Job* job) { return job->id == id; });
  const auto index = std::clamp<std::int64_t>(place - 1, 0, static_cast<std::int64_t>(queue.size()));
  queue.insert(queue.begin() + index, &found->second);
  auto change = s_.store.begin();
  for (std::size_t i = 0; i < queue.size(); ++i) {
    Job moved = *queue[i];
    moved.position = positions[i];
    s_.store.save(moved);
  }
  change.commit();
  for (std::size_t i = 0; i < queue.size(); ++i) queue[i]->position = positions[i];
  changed();
  want_schedule();
}

void Runner::command_line(const std::string& name, const std::string& line) {
  Printer& one = printer(name);
  if (is_emergency_stop(line)) {
    const std::string reason = "emergency stop by command";
    one.halt_now(reason);
    return halted(one.name(), reason);
  }
  if (!one.connected()) throw CommandError("the printer is not connected: " + one.offline_reason());
  s_.log.info("terminal", {{"printer", one.name()}, {"line", line}});
  one.command(line);
}

void Runner::halted(const std::string& name, const std::string& reason) {
  for (const auto& one : printers_) {
    if (!name.empty() && one->name() != name) continue;
    one->memory.held = reason;
    one->memory.bed_clear = false;
    if (one->pins()) one->pins()->cut();  // again: a bed-clear on its way may have forgiven it
    s_.log.warning("halt", {{"printer", one->name()}, {"reason", reason}});
    if (const Job* job = job_on(*one)) happen(job->id, Event::halt, [reason](Job& j) { j.message = reason; });
    save_memory(*one);
  }
  changed();
}

void Runner::show_upload(Job& job) {
  if (job.location == job.input) return;
  std::error_code error;
  if (identify(job.location)) {
    job.input = free_name(job.input);
    fs::rename(job.location, job.input, error);
  }
  if (!error && identify(job.input) == job.file) {
    job.location = job.input;
    try {
      s_.store.save(job);
    } catch (const StoreError& failure) {  // the next start finds the file by its new name
      s_.log.error("store", {{"job", std::to_string(job.id)}, {"reason", failure.what()}});
    }
  }
}

JobId Runner::add(const fs::path& upload, const std::string& name, const JobOptions& options,
                  const std::string& printer_name) {
  Printer& one = printer(printer_name);
  if (one.config().watch.empty())
    throw CommandError(one.name() + " has no watched folder to put the file in");
  const auto id = identify(upload);
  if (!id) throw CommandError("the upload is gone");
  const fs::path to = free_name(one.config().watch.front() / name);
  Job job;
  job.printer = one.name();
  job.folder = to.parent_path();
  job.input = to;
  job.location = upload;
  job.file = *id;
  job.options = options;
  job.copies = std::max(1, options.copies);
  job.received = utc_now();
  // The row first, with the hidden upload as its file: whatever comes between this and the new name, the job
  // is there once, with its options. start() finishes what is left undone.
  auto change = s_.store.begin();
  s_.store.insert(job);
  change.commit();
  show_upload(job);
  s_.log.info("received", {{"job", std::to_string(job.id)}, {"file", to.string()}, {"printer", job.printer}});
  const JobId out = job.id;
  jobs_.emplace(out, std::move(job));
  changed();
  want_schedule();
  return out;
}

}  // namespace voidpath::daemon
