#include "daemon/web/snapshot.h"

#include "daemon/jobs/facts_json.h"
#include "daemon/version.h"

#include <algorithm>

namespace voidpath::daemon {
namespace {

/// How far the print is, by the planner's time of its layers; by bytes where the file has no layers.
double progress_of(const Printer& printer) {
  const PrintTimer& timer = *printer.timer();
  const double planned = timer.planned_s();
  if (planned > 0) return std::clamp(timer.planned_done_s() / planned, 0.0, 1.0);
  const double size = static_cast<double>(printer.file_size());
  return size > 0 ? std::clamp(static_cast<double>(printer.file_position()) / size, 0.0, 1.0) : 0.0;
}

std::string state_of(const Printer& printer, const Job* job) {
  if (job != nullptr) return std::string(name_of(job->state));
  if (!printer.connected()) return "offline";
  if (!printer.memory.held.empty()) return "held";
  return "idle";
}

Json pins_json(const Printer& printer) {
  if (printer.pins() == nullptr) return {};
  Json out = Json::object();
  for (auto& [name, state] : printer.pins()->words()) out.set(name, std::move(state));
  return out;
}

Json printer_json(const Runner& runner, const Printer& printer) {
  const Job* job = runner.job_on(printer);
  const Job* next = nullptr;
  for (const Job* one : runner.queue()) {
    if (one->printer == printer.name() && queued(one->state) && next == nullptr) next = one;
  }
  Json heat = Json::object();
  for (const auto& [sensor, value] : printer.temperatures()) {
    heat.set(sensor, Json::object().set("actual_c", value.actual_c).set("target_c", value.target_c));
  }
  Json watch = Json::array();
  for (const auto& folder : printer.config().watch) watch.push(folder.string());
  Json differ = Json::array();
  for (const auto& one : printer.limits_differ) differ.push(one);
  Json out = Json::object();
  out.set("name", printer.name())
      .set("state", state_of(printer, job))
      .set("connected", printer.connected())
      .set("offline_reason", printer.offline_reason())
      .set("firmware", printer.memory.firmware)
      .set("temperatures", std::move(heat))
      .set("bed_clear", printer.memory.bed_clear)
      .set("auto_clear", printer.config().auto_clear)
      .set("job", job ? job_json(*job) : Json());
  const bool printing = job != nullptr && printer.timer() != nullptr && printer.job() == job->id;
  const double progress = printing ? progress_of(printer) : 0;
  out.set("progress", printing ? Json(progress) : Json())
      .set("elapsed_s", printing ? Json(printer.timer()->elapsed_s()) : Json())
      .set("left_s", printing ? Json(job->facts.predicted_s * (1 - progress)) : Json())
      .set("layer", printing ? Json(printer.timer()->layer()) : Json())
      .set("resends", printing ? Json(printer.link().resends) : Json())
      .set("doubts", printing ? Json(printer.link().doubts) : Json())
      .set("next", next ? job_json(*next) : Json())
      .set("waiting", runner.waiting_reason(printer))
      .set("pins", pins_json(printer))
      .set("limits_differ", std::move(differ))
      .set("watch", std::move(watch));
  return out;
}

}  // namespace

Json job_json(const Job& job) {
  const auto& facts = job.facts;
  return Json::object()
      .set("id", job.id)
      .set("file", job.file_name())
      .set("printer", job.printer)
      .set("state", std::string(name_of(job.state)))
      .set("message", job.message)
      .set("copies", job.copies)
      .set("copies_done", job.copies_done)
      .set("received", job.received)
      .set("method", facts.method)
      .set("why", facts.why)
      .set("direction", direction_json(facts.direction))
      .set("criteria", criteria_json(facts.criteria))
      .set("criteria_as_delivered", criteria_json(facts.criteria_as_delivered))
      .set("predicted_s", facts.predicted_s > 0 ? Json(facts.predicted_s) : Json())
      .set("predicted_raw_s", facts.predicted_raw_s > 0 ? Json(facts.predicted_raw_s) : Json())
      .set("as_delivered_s", facts.as_delivered_s)
      .set("as_delivered_is_rough", facts.as_delivered_is_rough)
      .set("layers", facts.layers)
      .set("filament_mm", facts.filament_mm)
      .set("limits_from", facts.limits_from)
      .set("limits", facts.limits);
}

Snapshot make_snapshot(const Runner& runner, const Settler& settler) {
  Snapshot out;
  Json printers = Json::array();
  for (const auto& printer : runner.printers()) printers.push(printer_json(runner, *printer));
  Json jobs = Json::array();
  for (const Job* job : runner.queue()) jobs.push(job_json(*job));
  Json arriving = Json::array();
  for (const auto& file : settler.files()) arriving.push(file.string());
  const auto& preparing = runner.preparing();
  Json worker;
  if (preparing.job != 0) {
    worker.set("job", preparing.job).set("phase", preparing.phase).set("fraction", preparing.fraction);
  }
  const auto queued_jobs = jobs.items().size();
  out.queue.set("jobs", std::move(jobs)).set("arriving", arriving);
  out.status.set("version", version())
      .set("printers", std::move(printers))
      .set("preparing", std::move(worker))
      .set("queue_length", queued_jobs)
      .set("arriving", std::move(arriving));
  return out;
}

}  // namespace voidpath::daemon
