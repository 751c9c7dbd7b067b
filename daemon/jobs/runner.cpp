#include "daemon/jobs/runner.h"

#include "daemon/jobs/filing.h"

#include <algorithm>
#include <utility>

namespace voidpath::daemon {
namespace {

/// How long after a failed write to the store what happened is written again, s.
constexpr double kStoreRetry_s = 5.0;
/// How long a shutdown waits for printers to end what they are at, s: the rest is done by closing the port.
constexpr double kShutdown_s = 15.0;

}  // namespace

Runner::Runner(Services services, config::DaemonConfig config)
    : s_(std::move(services)), config_(std::move(config)) {
  worker_ = std::make_unique<PrepareWorker>(
      s_.loop, s_.prepare, [this](JobId id, PrepareResult result) { on_prepared(id, std::move(result)); },
      [this](JobId id, std::string phase, double fraction) {
        preparing_ = {id, std::move(phase), fraction};
        changed();
      });
  for (const auto& printer : config_.printers) {
    printers_.push_back(
        std::make_unique<Printer>(s_.loop, printer, s_.port_options(printer), s_.port,
                                  [this](Printer& p, const fw::Event& e) { on_printer_event(p, e); }));
    attach_pins(*printers_.back());
  }
}

Runner::~Runner() {
  *alive_ = false;
  worker_.reset();
  printers_.clear();
}

void Runner::start() {
  for (auto& printer : printers_) {
    printer->memory = s_.store.printer(printer->name());
    recall_limits(*printer);
    // What an earlier run left on the bed is not known to be gone, whatever clears it after a finished print.
    if (printer->config().auto_clear && !printer->memory.known) printer->memory.bed_clear = true;
  }
  for (auto& job : s_.store.open_jobs()) jobs_.emplace(job.id, std::move(job));
  std::vector<JobId> ids;
  for (const auto& [id, job] : jobs_) ids.push_back(id);
  for (const JobId id : ids) {
    Job& job = jobs_.at(id);
    if (ended(job.state)) {  // the last run ended before it filed the input
      file(job, job.state == State::done ? "done" : "failed");
      continue;
    }
    show_upload(job);
    apply(id, Event::recovered, [](Job& j) {
      if (!on_printer(j.state) || j.state == State::cancelling) return;
      j.message =
          "was printing when the daemon or the power went; how far it got is not known. "
          "`voidpath resume-interrupted " +
          std::to_string(j.id) + "` prints it again from its beginning, `voidpath discard " +
          std::to_string(j.id) + "` drops it";
    });
    if (const auto found = jobs_.find(id); found != jobs_.end() && found->second.state == State::ready &&
                                           !std::filesystem::exists(gcode_of(id))) {
      apply(id, Event::input_changed);
    }
  }
  drop_stray_uploads();
  for (auto& printer : printers_) printer->open();
  want_schedule();
}

void Runner::drop_stray_uploads() const {
  for (const auto& printer : printers_)
    for (const auto& folder : printer->config().watch) {
      std::error_code error;
      for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end;
           it.increment(error)) {
        const auto& path = it->path();
        const bool held = std::any_of(jobs_.begin(), jobs_.end(),
                                      [&](const auto& entry) { return entry.second.location == path; });
        std::error_code ignored;
        if (!held && path.filename().string().starts_with(kUploadPrefix))
          std::filesystem::remove(path, ignored);
      }
    }
}

bool Runner::apply(JobId id, Event event, const Edit& edit) {
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) return false;
  const Job before = found->second;
  const Transition step = transition(before.state, event);
  if (!step.legal) return false;
  Job after = before;
  if (edit) edit(after);
  after.state = step.next;
  commit(before, after, step);
  found->second = after;
  if (before.state != after.state) {
    s_.log.info("job", {{"job", std::to_string(id)},
                        {"file", after.file_name()},
                        {"printer", after.printer},
                        {"from", std::string(name_of(before.state))},
                        {"to", std::string(name_of(after.state))},
                        {"by", std::string(name_of(event))},
                        {"message", after.message}});
  }
  if (has(step.effects, Effect::record) || has(step.effects, Effect::close_record)) ended_records_.erase(id);
  changed();
  perform(id, step);
  want_schedule();
  return true;
}

void Runner::happen(JobId id, Event event, const Edit& edit) {
  try {
    apply(id, event, edit);
  } catch (const StoreError& error) {
    s_.log.error("store", {{"job", std::to_string(id)}, {"reason", error.what()}});
    s_.loop.after(kStoreRetry_s, [this, id, event, edit, alive = alive_] {
      if (*alive) happen(id, event, edit);
    });
  }
}

void Runner::decide(JobId id, Event event, const Edit& edit) {
  try {
    apply(id, event, edit);
  } catch (const StoreError& error) {
    s_.log.error("store", {{"job", std::to_string(id)}, {"reason", error.what()}});
    s_.loop.after(kStoreRetry_s, [this, alive = alive_] {
      if (*alive) want_schedule();
    });
  }
}

void Runner::save_memory(Printer& printer) {
  try {
    s_.store.save_printer(printer.name(), printer.memory);
  } catch (const StoreError& error) {
    s_.log.error("store", {{"printer", printer.name()}, {"reason", error.what()}});
    s_.loop.after(kStoreRetry_s, [this, &printer, alive = alive_] {
      if (*alive) save_memory(printer);
    });
  }
}

void Runner::commit(const Job& before, Job& after, const Transition& step) {
  Printer* printer = find_printer(after.printer);
  const PrinterMemory memory = printer ? printer->memory : PrinterMemory{};
  auto record = printer ? printer->record : std::nullopt;
  try {
    auto change = s_.store.begin();
    if (printer && has(step.effects, Effect::soil_bed)) printer->memory.bed_clear = false;
    // Only an end that the printer took part in is known to have left it cool.
    const bool cooled =
        after.state == State::done || after.state == State::cancelled || after.state == State::ready;
    if (printer && on_printer(before.state) && cooled) printer->memory.may_be_hot = false;
    if (printer && has(step.effects, Effect::start_print)) {
      printer->memory.may_be_hot = true;
      PrintRecord started;
      started.job = after.id;
      started.file = after.file_name();
      started.started = utc_now();
      started.printer = after.printer;
      started.firmware = printer->memory.firmware;
      started.facts = after.facts;
      s_.store.open_record(started);
      printer->record = started;
    }
    if (has(step.effects, Effect::record) || has(step.effects, Effect::close_record)) {
      end_record(before, after, printer, has(step.effects, Effect::record));
    }
    if (printer) s_.store.save_printer(printer->name(), printer->memory);
    s_.store.save(after);
    change.commit();
  } catch (...) {
    if (printer) {
      printer->memory = memory;
      printer->record = record;
    }
    throw;
  }
}

void Runner::end_record(const Job& before, const Job& after, Printer* printer, bool needed) {
  std::optional<PrintRecord> record;
  const PrintTimer* timer = nullptr;
  if (printer && printer->record && printer->record->job == after.id) {
    record = printer->record;
    timer = printer->timer();
    printer->record.reset();
  } else if (const auto kept = ended_records_.find(after.id); kept != ended_records_.end()) {
    record = kept->second;
  } else {
    record = s_.store.last_record_of(after.id);
    if (record && record->state != "open") record.reset();
  }
  if (!record) {
    if (!needed) return;
    record.emplace();
    record->job = after.id;
    record->file = after.file_name();
    record->printer = after.printer;
    record->facts = after.facts;
  }
  const bool copy = after.state == State::ready && on_printer(before.state);
  record->state = copy ? name_of(State::done) : name_of(after.state);
  // Only a print that came to its end has run what clears the bed.
  const bool printed = record->id != 0 && record->state == name_of(State::done);
  if (printed && printer && printer->config().auto_clear) printer->memory.bed_clear = true;
  record->ended = utc_now();
  if (record->state != name_of(State::done)) record->reason = after.message;
  if (timer) take_times(*record, *timer);
  s_.store.close_record(*record);
}

void Runner::perform(JobId id, const Transition& step) {
  Job& job = jobs_.at(id);
  Printer* printer = find_printer(job.printer);
  const bool there = printer && printer->job() == id;
  const auto effect = [&](Effect one) { return has(step.effects, one); };
  if (effect(Effect::stop_prepare) && preparing_.job == id) worker_->stop();
  if (effect(Effect::pause_print) && there) printer->pause();
  if (effect(Effect::resume_print) && there) printer->resume();
  if (effect(Effect::cancel_print) && there) printer->cancel(job.message);
  if (effect(Effect::halt_printer) && printer) printer->halt_now(job.message);
  if (effect(Effect::start_print)) start_print(job);
  if (effect(Effect::file_done)) file(job, "done");
  if (effect(Effect::file_failed)) file(job, "failed");
}

void Runner::start_print(const Job& job) {
  Printer* printer = find_printer(job.printer);
  if (!printer) return;
  try {
    printer->start(job.id, gcode_of(job.id), job.facts.layer_times);
  } catch (const std::exception& error) {
    // Not from within the transition that led here.
    s_.loop.post([this, alive = alive_, id = job.id, why = std::string(error.what())] {
      if (*alive) happen(id, Event::print_failed, [why](Job& j) { j.message = why; });
    });
  }
}

void Runner::file(Job& job, const char* subfolder) {
  const JobId id = job.id;
  try {
    PrintRecord record = s_.store.last_record_of(id).value_or(PrintRecord{});
    if (record.id == 0) {  // given up without an attempt worth a row
      record.job = id;
      record.file = job.file_name();
      record.printer = job.printer;
      record.facts = job.facts;
    }
    if (job.state != State::done || record.state.empty()) {
      record.state = name_of(job.state);
      record.reason = job.message;
    }
    file_input(job, subfolder, record);
  } catch (const StoreError& error) {
    s_.log.error("store", {{"job", std::to_string(id)}, {"reason", error.what()}});
    s_.loop.after(kStoreRetry_s, [this, id, subfolder, alive = alive_] {
      if (!*alive) return;
      if (const auto found = jobs_.find(id); found != jobs_.end() && ended(found->second.state))
        file(found->second, subfolder);
    });
    return;
  } catch (const std::exception& error) {
    s_.log.error("filing",
                 {{"job", std::to_string(id)}, {"file", job.input.string()}, {"reason", error.what()}});
    // An input that cannot be moved must not be taken for a new one: its row stays open and holds it.
    if (identify(job.location) == job.file && job.location == job.input) {
      job.message +=
          (job.message.empty() ? "" : "; ") + std::string("the input could not be moved: ") + error.what();
      std::error_code ignored;
      std::filesystem::remove_all(gcode_of(id).parent_path(), ignored);
      return;
    }
  }
  std::error_code ignored;
  std::filesystem::remove_all(gcode_of(id).parent_path(), ignored);
  job.filed = true;
  try {
    s_.store.save(job);
  } catch (const StoreError& error) {
    s_.log.error("store", {{"job", std::to_string(id)}, {"reason", error.what()}});
    return;
  }
  jobs_.erase(id);
}

void Runner::shutdown(std::function<void()> finished) {
  stopping_ = true;
  finished_ = std::move(finished);
  std::vector<JobId> ids;
  for (const auto& [id, job] : jobs_) ids.push_back(id);
  for (const JobId id : ids) {
    happen(id, Event::shutdown, [](Job& j) {
      if (!on_printer(j.state) || j.state == State::cancelling) return;
      j.message = "ended because the daemon was stopped; `voidpath resume-interrupted " +
                  std::to_string(j.id) + "` prints it again from its beginning";
    });
  }
  s_.loop.after(kShutdown_s, [this, alive = alive_] {
    if (*alive && finished_) std::exchange(finished_, nullptr)();
  });
  check_shutdown();
}

void Runner::check_shutdown() {
  if (!stopping_ || !finished_) return;
  for (const auto& printer : printers_) {
    if (printer->busy()) return;
  }
  s_.loop.post(std::exchange(finished_, nullptr));
}

}  // namespace voidpath::daemon
