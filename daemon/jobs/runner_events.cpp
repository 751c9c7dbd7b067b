#include "daemon/jobs/printer_limits.h"
#include "daemon/jobs/runner.h"
#include "engine/calibrate/correction.h"
#include "firmware-io/heaters_off.h"

#include <utility>

/// What printers and the worker report, brought to the table.
namespace voidpath::daemon {

void Runner::on_printer_event(Printer& printer, const fw::Event& event) {
  const auto job = printer.job();
  const auto& what = event.what;
  if (std::holds_alternative<fw::Connected>(what)) {
    s_.log.info("connected", {{"printer", printer.name()}, {"firmware", printer.memory.firmware}});
    if (!job && std::exchange(printer.memory.may_be_hot, false)) {
      s_.log.warning("heaters_off", {{"printer", printer.name()}, {"reason", "a print was cut off"}});
      for (const std::string& line : fw::heaters_off(std::get<fw::Connected>(what).firmware))
        printer.command(line);
    }
    save_memory(printer);
    if (!printer.limits()) keep_limits(printer);
    want_schedule();
  } else if (const auto* down = std::get_if<fw::Disconnected>(&what)) {
    s_.log.warning("disconnected", {{"printer", printer.name()}, {"reason", down->reason}});
  } else if (std::holds_alternative<fw::LimitsKnown>(what)) {
    keep_limits(printer);
    compare_limits(printer);
  } else if (const auto* message = std::get_if<fw::Message>(&what)) {
    s_.log.info("printer", {{"printer", printer.name()}, {"text", message->text}});
  } else if (const auto* stats = std::get_if<fw::LinkStats>(&what)) {
    s_.log.info("stats", {{"printer", printer.name()},
                          {"lines", std::to_string(stats->lines_sent)},
                          {"resends", std::to_string(stats->resends)},
                          {"doubts", std::to_string(stats->doubts)},
                          {"bytes", std::to_string(stats->bytes_sent)},
                          {"window", std::to_string(stats->window_bytes)}});
  }
  changed();
  pins_of_event(printer, event);
  if (!job) return;
  if (std::holds_alternative<fw::MotionStarted>(what)) {
    happen(*job, Event::motion);
  } else if (const auto* paused = std::get_if<fw::Paused>(&what)) {
    const std::string ours = printer.take_pause_reason();
    const std::string why = !paused->reason.empty() ? paused->reason
                            : paused->by_printer    ? "paused by the printer"
                                                    : ours;
    happen(*job, Event::printer_paused, [why](Job& j) { j.message = why; });
  } else if (const auto* question = std::get_if<fw::Message>(&what); question && question->asks) {
    const auto asked = jobs_.find(*job);
    if (asked != jobs_.end() && asked->second.state == State::paused)
      happen(*job, Event::printer_paused, [why = question->text](Job& j) { j.message = why; });
  } else if (std::holds_alternative<fw::Resumed>(what)) {
    happen(*job, Event::printer_resumed, [](Job& j) { j.message.clear(); });
  } else {
    on_print_end(printer, event);
  }
}

/// So that what is prepared before the printer answers goes by what it said last.
void Runner::recall_limits(Printer& printer) {
  try {
    if (const auto kept = s_.store.limits(printer.name())) printer.recall(*kept);
  } catch (const std::exception& error) {
    s_.log.warning("store", {{"printer", printer.name()}, {"reason", error.what()}});
  }
  if (printer.limits()) compare_limits(printer);
}

/// A printer that is another one now, and says nothing of itself, leaves nothing to be kept.
void Runner::keep_limits(Printer& printer) {
  if (!printer.limits()) printer.limits_differ.clear();
  try {
    if (const auto kept = printer.kept_limits())
      s_.store.save_limits(printer.name(), *kept);
    else
      s_.store.forget_limits(printer.name());
  } catch (const StoreError& error) {
    // Nothing is lost but time: the next connection tells them again.
    s_.log.warning("store", {{"printer", printer.name()}, {"reason", error.what()}});
  }
}

/// Tells the user where the profile is wrong about the printer. What is prepared from now on goes by the
/// printer.
void Runner::compare_limits(Printer& printer) {
  printer.limits_differ.clear();
  try {
    const auto& c = printer.config();
    printer.limits_differ =
        differences(config::load_profile(c.profile, c.material, c.quality, {}), *printer.limits());
  } catch (const std::exception& error) {
    s_.log.warning("profile", {{"printer", printer.name()}, {"reason", error.what()}});
    return;
  }
  for (const auto& one : printer.limits_differ)
    s_.log.warning("profile_differs", {{"printer", printer.name()}, {"what", one}});
}

void Runner::on_print_end(Printer& printer, const fw::Event& event) {
  const JobId id = *printer.job();
  const auto found = jobs_.find(id);
  const bool finished = std::holds_alternative<fw::PrintFinished>(event.what);
  const auto* failed = std::get_if<fw::PrintFailed>(&event.what);
  const auto* down = std::get_if<fw::Disconnected>(&event.what);
  const bool cancelled = std::holds_alternative<fw::PrintCancelled>(event.what);
  if (!finished && !failed && !down && !cancelled) return;
  if (found != jobs_.end()) {
    const Job& job = found->second;
    if (printer.record && printer.timer()) {
      take_times(*printer.record, *printer.timer());
      ended_records_[id] = *printer.record;
    }
    if (finished) {
      const bool last = job.copies_done + 1 >= job.copies;
      happen(id, last ? Event::finished_last : Event::finished_copy, [](Job& j) {
        ++j.copies_done;
        j.message = j.copies > 1 ? "copy " + std::to_string(j.copies_done) + " of " +
                                       std::to_string(j.copies) + " printed"
                                 : std::string();
      });
    } else if (cancelled) {
      happen(id, Event::print_cancelled);
    } else {
      const std::string why =
          failed ? failed->reason : "the connection to the printer was lost: " + down->reason;
      happen(id, Event::print_failed, [why](Job& j) {
        if (j.state != State::cancelling) j.message = why;
      });
    }
  }
  // The printer counts as busy until this event has been dealt with.
  s_.loop.post([this, alive = alive_] {
    if (!*alive) return;
    check_shutdown();
    want_schedule();
  });
}

void Runner::correct(const Job& job, JobFacts& facts) {
  const Printer* printer = find_printer(job.printer);
  const std::string firmware = printer ? printer->memory.firmware : std::string();
  const auto fit =
      calibrate::fit_correction(s_.store.observations(job.printer, facts.profile_sha256, firmware));
  if (!fit) return;
  facts.predicted_s = facts.predicted_raw_s * fit->factor;
  if (facts.as_delivered_s) *facts.as_delivered_s *= fit->factor;
}

void Runner::on_prepared(JobId id, PrepareResult result) {
  preparing_ = {};
  changed();
  want_schedule();
  const auto found = jobs_.find(id);
  if (found == jobs_.end() || found->second.state != State::preparing) return;  // cancelled meanwhile
  // An edit may be repeated later, when this call is long over: it owns what it needs.
  const auto prepared = std::make_shared<const PrepareResult>(std::move(result));
  for (const auto& message : prepared->slicer_messages)
    s_.log.info("slicer", {{"job", std::to_string(id)}, {"text", message}});
  switch (prepared->kind) {
    case PrepareResult::Kind::prepared:
      happen(id, Event::prepared, [this, prepared](Job& job) {
        job.facts = prepared->facts;
        job.copies = prepared->copies;
        job.message = job.facts.why;
        correct(job, job.facts);
      });
      break;
    case PrepareResult::Kind::failed:
      happen(id, Event::prepare_failed, [prepared](Job& job) {
        job.facts = prepared->facts;
        job.message = prepared->message;
      });
      break;
    case PrepareResult::Kind::unsettled:
      happen(id, Event::input_changed, [](Job& job) { job.message = "the file is still being written"; });
      s_.settler.note(found->second.location, s_.loop.now_s());
      break;
    case PrepareResult::Kind::stopped:
      happen(id, Event::input_changed);
      break;
  }
}

}  // namespace voidpath::daemon
