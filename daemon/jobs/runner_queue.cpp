#include "daemon/jobs/runner.h"

#include <algorithm>

/// What comes in, and who is next.
namespace voidpath::daemon {

namespace fs = std::filesystem;

void Runner::want_schedule() {
  if (std::exchange(schedule_posted_, true)) return;
  s_.loop.post([this, alive = alive_] {
    if (!*alive) return;
    schedule_posted_ = false;
    schedule();
  });
}

void Runner::schedule() {
  if (stopping_) return;
  for (const auto& printer : printers_) {
    schedule_printer(*printer);
    update_pins(*printer);
  }
  schedule_prepare();
}

void Runner::schedule_printer(Printer& printer) {
  const auto queue = queue_of(printer.name());
  for (std::size_t i = 1; i < queue.size(); ++i) {
    if (queue[i]->state == State::waiting_bed) decide(queue[i]->id, Event::turn_lost);
  }
  if (queue.empty() || printer.busy() || job_on(printer)) return;
  const JobId id = queue.front()->id;
  if (queue.front()->state == State::ready) decide(id, Event::turn);
  const auto head = jobs_.find(id);
  if (head == jobs_.end() || head->second.state != State::waiting_bed) return;
  if (!about_to_print(printer)) return;
  update_pins(printer);
  if (!printer.connected() || (printer.pins() && !printer.pins()->power_ready())) return;
  if (!identify(head->second.location)) {
    happen(id, Event::cancel, [](Job& job) { job.message = "its file was taken out of the folder"; });
    return;
  }
  decide(id, Event::bed_clear, [](Job& job) { job.message.clear(); });
}

void Runner::schedule_prepare() {
  if (worker_->busy()) return;
  const Job* next = nullptr;
  for (const auto& [id, job] : jobs_) {
    if (job.state != State::received || s_.settler.pending(job.location)) continue;
    if (find_printer(job.printer) == nullptr) continue;
    const bool earlier =
        next == nullptr || (job.printer == next->printer ? job.position < next->position : job.id < next->id);
    if (earlier) next = &job;
  }
  if (next == nullptr) return;
  PrepareTask task;
  task.job = next->id;
  task.input = next->location;
  task.file = next->file;
  task.options = next->options;
  task.folder = next->folder;
  task.gcode_out = gcode_of(next->id);
  const Printer& printer = *find_printer(next->printer);
  task.printer = printer.config();
  task.firmware = printer.limits();
  task.s3g = printer.s3g();
  task.orient = config_.orient;
  task.slicer = config_.slicer;
  decide(task.job, Event::prepare_begun, [](Job& job) { job.message.clear(); });
  const auto found = jobs_.find(task.job);
  if (found == jobs_.end() || found->second.state != State::preparing) return;
  preparing_ = {task.job, "", 0};
  worker_->start(std::move(task));
}

bool Runner::owns(const fs::path& file, const FileId& id) const {
  return std::any_of(jobs_.begin(), jobs_.end(), [&](const auto& entry) {
    const Job& job = entry.second;
    return job.location == file && job.file == id &&
           !(job.state == State::received && s_.settler.pending(file));
  });
}

void Runner::take(const StableFile& file) {
  for (auto& [id, job] : jobs_) {
    if (job.location == file.path && job.file == file.id) {
      want_schedule();  // it may have waited for this
      return;
    }
    if (job.location == file.path && queued(job.state)) {
      happen(id, Event::input_changed, [file](Job& changed_job) {
        changed_job.file = file.id;
        changed_job.facts = {};
        changed_job.message = "the file was replaced";
      });
      return;
    }
    if (job.file == file.id && !identify(job.location)) {  // renamed within the folders
      Job renamed = job;
      renamed.location = file.path;
      renamed.input = file.path;
      s_.store.save(renamed);
      job = renamed;
      changed();
      return;
    }
  }
  const auto* printer = printer_of_folder(file.path.parent_path());
  if (printer == nullptr) return;
  Job job;
  job.printer = printer->name;
  job.folder = file.path.parent_path();
  job.input = file.path;
  job.location = file.path;
  job.file = file.id;
  job.received = utc_now();
  auto change = s_.store.begin();
  s_.store.insert(job);
  change.commit();
  s_.log.info("received",
              {{"job", std::to_string(job.id)}, {"file", job.input.string()}, {"printer", job.printer}});
  jobs_.emplace(job.id, std::move(job));
  changed();
  want_schedule();
}

std::vector<Job*> Runner::queue_of(const std::string& printer) {
  std::vector<Job*> out;
  for (auto& [id, job] : jobs_) {
    if (job.printer == printer && queued(job.state)) out.push_back(&job);
  }
  std::sort(out.begin(), out.end(), [](const Job* a, const Job* b) { return a->position < b->position; });
  return out;
}

std::vector<const Job*> Runner::queue() const {
  std::vector<const Job*> out;
  for (const auto& [id, job] : jobs_) {
    if (!ended(job.state)) out.push_back(&job);
  }
  std::sort(out.begin(), out.end(), [](const Job* a, const Job* b) {
    return std::tie(a->printer, a->position) < std::tie(b->printer, b->position);
  });
  return out;
}

Printer* Runner::find_printer(const std::string& name) const {
  for (const auto& printer : printers_) {
    if (printer->name() == name) return printer.get();
  }
  return nullptr;
}

const config::PrinterConfig* Runner::printer_of_folder(const fs::path& folder) const {
  for (const auto& printer : printers_) {
    const auto& watch = printer->config().watch;
    if (std::find(watch.begin(), watch.end(), folder) != watch.end()) return &printer->config();
  }
  return nullptr;
}

fs::path Runner::gcode_of(JobId id) const {
  return config_.state_dir / "jobs" / std::to_string(id) / "print.gcode";
}

const Job* Runner::job_on(const Printer& printer) const {
  for (const auto& [id, job] : jobs_) {
    if (job.printer == printer.name() && on_printer(job.state)) return &job;
  }
  return nullptr;
}

std::string Runner::waiting_reason(const Printer& printer) const {
  if (job_on(printer)) return {};
  if (printer.busy()) return "the printer ends its last print";
  const Job* head = nullptr;
  const Job* interrupted = nullptr;
  for (const Job* job : queue()) {
    if (job->printer != printer.name()) continue;
    if (job->state == State::interrupted && interrupted == nullptr) interrupted = job;
    if (queued(job->state) && head == nullptr) head = job;
  }
  if (printer.pins() != nullptr && printer.pins()->stop_pulled()) {
    return "the emergency stop is pulled: let it go, then `voidpath bed-clear`";
  }
  if (!printer.memory.held.empty()) {
    return printer.memory.held + ": nothing starts before `voidpath bed-clear`";
  }
  if (head == nullptr) {
    return interrupted
               ? "job " + std::to_string(interrupted->id) + " was interrupted and waits for a decision"
               : "";
  }
  if (head->state == State::received || head->state == State::preparing)
    return head->file_name() + " is being prepared";
  const auto* pins = printer.pins();
  if (pins != nullptr && !pins->blocker().empty()) return pins->blocker();
  const bool powered = pins == nullptr || pins->power_ready();
  if (!printer.connected() && powered) return "the printer is not connected: " + printer.offline_reason();
  if (!printer.memory.bed_clear)
    return "the bed is not known to be clear: take the part off, then `voidpath bed-clear`";
  return powered ? "" : "the printer's power comes on";
}

}  // namespace voidpath::daemon
