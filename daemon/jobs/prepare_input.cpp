#include "config/digest.h"
#include "daemon/intake/file_checks.h"
#include "daemon/jobs/filing.h"
#include "daemon/jobs/prepare_worker.h"
#include "daemon/jobs/printer_limits.h"
#include "daemon/slicer/foreign.h"
#include "engine/gcode/estimate.h"
#include "engine/pipeline/prepare.h"
#include "firmware-io/printer_port.h"
#include "firmware-io/s3g/check_file.h"
#include "firmware-io/s3g/encoder.h"

#include <cerrno>
#include <chrono>
#include <fstream>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace voidpath::daemon {
namespace {

namespace fs = std::filesystem;

/// Fields that the nearer file sets win; settings of both apply, the nearer ones last.
void lay_over(config::JobOverrides& base, const config::JobOverrides& nearer) {
  if (!nearer.method.empty()) base.method = nearer.method;
  if (!nearer.slicer.empty()) base.slicer = nearer.slicer;
  if (!nearer.material.empty()) base.material = nearer.material;
  if (!nearer.quality.empty()) base.quality = nearer.quality;
  if (nearer.scale) base.scale = nearer.scale;
  if (nearer.copies) base.copies = nearer.copies;
  base.set.insert(base.set.end(), nearer.set.begin(), nearer.set.end());
}

/// The model's own override file: beside it where it is now, else where it was dropped, under the name it had
/// there; an input that is tried again lies in `failed` or `done`. Empty if there is none.
fs::path own_overrides(const PrepareTask& task) {
  const auto named = [](const fs::path& folder, const fs::path& model) {
    return folder / (model.stem().string() + ".voidpath.yaml");
  };
  std::error_code error;
  for (const auto& file :
       {named(task.input.parent_path(), task.input), named(task.folder, name_when_dropped(task.input))}) {
    if (fs::exists(file, error)) return file;
  }
  return {};
}

config::JobOverrides overrides_for(const PrepareTask& task) {
  config::JobOverrides out;
  std::error_code error;
  if (const auto file = task.folder / ".voidpath.yaml"; fs::exists(file, error)) {
    lay_over(out, config::load_overrides(file));
  }
  if (const auto file = own_overrides(task); !file.empty()) lay_over(out, config::load_overrides(file));
  if (!task.options.method.empty()) out.method = task.options.method;
  if (!task.options.slicer.empty()) out.slicer = task.options.slicer;
  if (task.options.scale > 0) out.scale = task.options.scale;
  if (task.options.copies > 0) out.copies = task.options.copies;
  return out;
}

void sync_to_disk(const fs::path& file) {
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0 || ::fsync(fd) != 0) {
    const int why = errno;
    if (fd >= 0) ::close(fd);
    throw std::runtime_error("cannot write " + file.string() + ": " + std::generic_category().message(why));
  }
  ::close(fd);
}

/// The queue prints its own copy: what happens to the dropped file later cannot reach a running print.
void copy_gcode(const fs::path& from, const fs::path& to) {
  const fs::path part = to.string() + ".part";
  std::error_code error;
  fs::copy_file(from, part, fs::copy_options::overwrite_existing, error);
  if (!error) fs::rename(part, to, error);
  if (error) {
    std::error_code ignored;
    fs::remove(part, ignored);
    throw std::runtime_error("cannot copy " + from.string() + " to " + to.string() + ": " + error.message());
  }
}

void take_estimate(JobFacts& facts, const gcode::Estimate& estimate) {
  facts.estimate_s = estimate.predicted_s;
  facts.predicted_raw_s = estimate.after_heating_s > 0 ? estimate.after_heating_s : estimate.predicted_s;
  facts.predicted_s = facts.predicted_raw_s;
  facts.layers = static_cast<std::int64_t>(estimate.layers.size());
  facts.filament_mm = estimate.filament_mm;
  facts.layer_times = estimate.layers;
  facts.notes.insert(facts.notes.end(), estimate.notes.begin(), estimate.notes.end());
}

void take_choice(JobFacts& facts, const orient::Choice& choice) {
  facts.method = orient::to_string(choice.method);
  facts.why = choice.why;
  const auto& chosen = choice.candidates.at(choice.chosen);
  facts.direction = {chosen.direction.x(), chosen.direction.y(), chosen.direction.z()};
  facts.criteria = chosen.criteria;
  facts.criteria_as_delivered = choice.candidates.at(choice.as_delivered).criteria;
}

/// A printer's own profile is for the configured slicer, not for another one that a job asks for.
fs::path slicer_profile(const PrepareTask& task, const std::string& named) {
  return named.empty() || named == task.slicer.name ? task.printer.slicer_profile : fs::path();
}

void prepare_model(const PrepareTask& task, const config::JobOverrides& overrides,
                   const config::Profile& profile, const run::Context& ctx, PrepareResult& result) {
  JobFacts& facts = result.facts;
  pipeline::PrepareOptions options;
  options.import.scale = overrides.scale.value_or(1.0);
  options.orient = config::search_options(task.orient, profile);
  if (!overrides.method.empty()) {
    const auto method = orient::method_from(overrides.method);
    if (!method) {
      throw config::ConfigError("method: " + overrides.method +
                                " is none of toolpath, thesis, ahsan, as-delivered");
    }
    options.orient.method = *method;
  }
  options.budget_s = task.orient.budget_s;
  options.now_s = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  };
  options.print = profile.print;
  options.limits = profile.limits;
  const auto own_profile = slicer_profile(task, overrides.slicer);
  options.slicer = foreign_slicer(task.slicer, overrides.slicer, own_profile);
  facts.profile_sha256 = slicing_sha256(task.slicer, overrides.slicer, own_profile, profile.sha256);
  const auto prepared = pipeline::prepare(task.input, task.gcode_out, options, true, ctx);
  take_choice(facts, prepared.choice);
  take_estimate(facts, prepared.estimate);
  if (prepared.as_delivered_s) {
    const auto& e = prepared.estimate;
    // What comes before heating is the same for both.
    const double before_s = e.after_heating_s > 0 ? e.predicted_s - e.after_heating_s : 0;
    facts.as_delivered_s = *prepared.as_delivered_s - before_s;
    facts.as_delivered_is_rough = prepared.as_delivered_is_rough;
  }
  if (facts.filament_mm <= 0) facts.filament_mm = prepared.stats.filament_mm;
  facts.notes.insert(facts.notes.end(), prepared.model.notes.begin(), prepared.model.notes.end());
  facts.notes.insert(facts.notes.end(), prepared.slicer_messages.begin(), prepared.slicer_messages.end());
  result.slicer_messages = prepared.slicer_messages;
}

/// Reads the file as the printer's session would.
void check_for_printer(const PrepareTask& task, const run::Context& ctx) {
  const auto gcode = fw::open_gcode_file(task.gcode_out.string());
  try {
    fw::SourceLine line;
    if (task.s3g) fw::s3g::check_file(*gcode, *task.s3g, ctx.stop);
    while (!ctx.stop.stop_requested() && gcode->fetch(line)) continue;
  } catch (const fw::s3g::EncodeError& error) {
    throw std::runtime_error(task.gcode_out.string() + ": " + error.what());
  }
  ctx.check();
}

/// Tells of the user's file where an error is of what was made of it.
std::string in_users_file(const PrepareTask& task, std::string message) {
  const std::string made = task.gcode_out.string();
  if (!message.starts_with(made)) return message;
  const bool ready = input_kind(task.input) == InputKind::gcode;
  return message.replace(0, made.size(), task.input.string() + (ready ? "" : ", sliced"));
}

PrepareResult run_task(const PrepareTask& task, const run::Context& ctx) {
  PrepareResult result;
  fs::create_directories(task.gcode_out.parent_path());
  const auto overrides = overrides_for(task);
  result.copies = overrides.copies.value_or(1);
  auto& facts = result.facts;
  facts.model_sha256 = config::sha256_of_file(task.input);
  auto profile = config::load_profile(
      task.printer.profile, overrides.material.empty() ? task.printer.material : overrides.material,
      overrides.quality.empty() ? task.printer.quality : overrides.quality, overrides.set);
  if (task.firmware) profile = with_limits(std::move(profile), *task.firmware);
  facts.profile_sha256 = profile.sha256;
  facts.limits_from = task.firmware ? "printer" : "profile";
  facts.limits = limits_text(profile);

  if (input_kind(task.input) == InputKind::gcode) {
    facts.method = "gcode";
    facts.why = "ready G-code, printed as it is";
    copy_gcode(task.input, task.gcode_out);
    auto limits = profile.limits;
    limits.baud = task.printer.baud;
    take_estimate(facts, gcode::estimate_file(task.gcode_out, limits, ctx));
  } else {
    auto with_line = profile;
    with_line.limits.baud = task.printer.baud;
    prepare_model(task, overrides, with_line, ctx, result);
  }
  check_for_printer(task, ctx);
  sync_to_disk(task.gcode_out);
  result.kind = PrepareResult::Kind::prepared;
  return result;
}

/// Whether what went wrong may be due to a file that is not complete, or was replaced meanwhile.
bool unsettled(const PrepareTask& task) {
  const auto now = identify(task.input);
  return now && (*now != task.file || open_for_writing(task.input));
}

}  // namespace

PrepareResult prepare_input(const PrepareTask& task, const run::Context& ctx) {
  PrepareResult result;
  try {
    result = run_task(task, ctx);
    if (unsettled(task)) result.kind = PrepareResult::Kind::unsettled;
    return result;
  } catch (const run::Stopped&) {
    result.kind = PrepareResult::Kind::stopped;
  } catch (const std::exception& error) {
    result.kind = unsettled(task) ? PrepareResult::Kind::unsettled : PrepareResult::Kind::failed;
    result.message = in_users_file(task, error.what());
    if (!identify(task.input)) result.message = task.input.string() + " is gone: it was removed or renamed";
  }
  std::error_code ignored;
  fs::remove_all(task.gcode_out.parent_path(), ignored);
  return result;
}

}  // namespace voidpath::daemon
