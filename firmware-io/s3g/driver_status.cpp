// Who is there, and what it says of itself: temperatures, build, faults, the panel.
#include "firmware-io/s3g/driver.h"

#include <algorithm>
#include <utility>

namespace voidpath::fw::s3g {
namespace {

/// A host of this version or later is told the firmware's true version.
constexpr std::uint16_t kHostVersion = 100;
/// Between greetings. A printer that boots hears none of them.
constexpr double kGreetAgain_s = 0.5;
constexpr double kPollHot_s = 2;
constexpr double kPollCold_s = 5;
constexpr double kBuildPoll_s = 1;
constexpr double kHot_c = 45;
/// Until the firmware's state shows what a pause button or toggle did.
constexpr double kPauseSettles_s = 2;
/// Between glances that keep the account of the queue.
constexpr double kGlancePause_s = 0.5;

constexpr std::size_t kVersionBytes = 3;

constexpr std::uint8_t kSailfish = 0x80;

std::string version_text(std::uint32_t version) {
  return std::to_string(version / 100) + "." + std::to_string(version % 100);
}

bool tells_of_heater_failure(const Answer& answer) {
  return query_of(answer.query) == Query::board_status && answer.code == ReplyCode::ok &&
         (little_endian(answer.data, 0, 1) & kHeatShutdown) != 0;
}

}  // namespace

void Driver::opened(double t) {
  last_t_ = t;
  link_.restart(t);
  forget_sending();
  firmware_ = {};
  firmware_.extruders = options_.machine.extruders;
  sensors_.clear();
  build_ = BuildState::none;
  halt_heard_ = false;
  phase_ = Phase::greeting;
  greeting_since(t);
  phase_deadline_ = t;
  pump(t);
}

void Driver::greeting_since(double t) {
  greeting_until_ = t + options_.boot_wait_s + options_.timing.silence_s;
}

// The first packets may meet a printer that is booting.
void Driver::greet(double t) {
  if (t >= greeting_until_) return disconnect("the printer does not answer");
  link_.restart(t);
  link_.ask_once(Payload(Query::version).u16(kHostVersion).bytes(), t);
  phase_deadline_ = t + kGreetAgain_s;
}

void Driver::on_identity(const Answer& answer, double t) {
  const Query query = query_of(answer.query);
  const bool good = answer.code == ReplyCode::ok;
  if (answer.code == ReplyCode::heater_failure) return disconnect(kHeatersShut);
  if (query == Query::version) {
    if (!good || answer.data.size() + 1 != kVersionBytes) return;  // greeted again
    firmware_.name = "MakerBot " + version_text(little_endian(answer.data, 0, 2));
    phase_ = Phase::identifying;
    phase_deadline_ = t + options_.timing.silence_s;
    link_.ask({Payload(Query::advanced_version).u16(kHostVersion).bytes()}, t);
  } else if (query == Query::advanced_version) {
    // Old firmware does not know the question.
    if (good && answer.data.size() >= 5) {
      const bool sailfish = little_endian(answer.data, 4, 1) == kSailfish;
      firmware_.name =
          (sailfish ? "Sailfish " : "MakerBot ") + version_text(little_endian(answer.data, 0, 2));
    }
    become_ready(t);
  }
}

void Driver::become_ready(double t) {
  phase_ = Phase::ready;
  last_loss_.clear();
  poll_t_ = build_t_ = t;
  if (!std::exchange(connected_, true)) emit(Connected{firmware_});
}

void Driver::schedule_polls(double t) {
  if (!polls_.empty()) return;
  if (job_ && !link_.draining() && link_.account().wants_check() && t >= glance_t_ + kGlancePause_s &&
      glance_step_ == 0) {
    glance_t_ = t;
    glance_step_ = 1;
    for (const Query query : {Query::build, Query::free_buffer, Query::build}) {
      polls_.push_back(question(query));
    }
  }
  if (t >= build_t_) {
    build_t_ = t + (job_ ? kBuildPoll_s : kPollCold_s);
    polls_.push_back(question(Query::build));
  }
  if (t < poll_t_) return;
  const bool hot = std::any_of(sensors_.begin(), sensors_.end(), [](const auto& sensor) {
    return sensor.second.actual_c > kHot_c || sensor.second.target_c > 0;
  });
  poll_t_ = t + (hot ? kPollHot_s : kPollCold_s);
  for (int tool = 0; tool < options_.machine.extruders; ++tool) {
    polls_.push_back(tool_question(tool, ToolQuery::temperature));
    polls_.push_back(tool_question(tool, ToolQuery::target));
  }
  if (options_.machine.heated_bed) {
    polls_.push_back(tool_question(0, ToolQuery::bed_temperature));
    polls_.push_back(tool_question(0, ToolQuery::bed_target));
  }
  polls_.push_back(question(Query::board_status));
}

void Driver::on_answer(const Answer& answer, double t) {
  if (phase_ == Phase::greeting || phase_ == Phase::identifying) return on_identity(answer, t);
  if (phase_ == Phase::aborting) return on_aborted(answer.code, t);
  if (phase_ == Phase::halted) {
    halt_heard_ = true;
    phase_ = Phase::closed;
  }
  if (phase_ != Phase::ready) return;
  if (answer.code == ReplyCode::heater_failure) return on_refused({{}, answer.code});
  if (job_ && tells_of_heater_failure(answer)) return drop_job(PrintFailed{kHeatersShut});
  if (told_cancelled_) return on_cancelled(answer);
  if (answer.code == ReplyCode::cancelled) return on_refused({{}, answer.code});
  if (asked_room_) return on_room(answer, t);
  if (asked_by_job_) {
    if (!job_) return;
    job_->on_answer(answer, t);
    if (job_->paused() && !wants_paused_) want_paused(true);  // the file asks for it
    return;
  }
  if (answer.code == ReplyCode::ok) on_status(answer, t);
  if (answer.code != ReplyCode::ok && glance_step_ != 0 && query_of(answer.query) == Query::build)
    glance_step_ = 0;
}

// What was said after the printer told of a cancel: it was one.
void Driver::on_cancelled(const Answer& answer) {
  if (query_of(answer.query) != Query::board_status) return;
  told_cancelled_ = false;
  emit(Message{"cancelled at the printer's panel"});
  drop_job(PrintCancelled{});
}

void Driver::on_status(const Answer& answer, double t) {
  switch (query_of(answer.query)) {
    case Query::tool:
      return on_tool_answer(answer);
    case Query::free_buffer:
      glance_.free = little_endian(answer.data, 0, 4);
      if (glance_step_ == 2) glance_step_ = 3;
      return;
    case Query::build:
      return on_build(answer, t);
    case Query::board_status: {
      const auto status = little_endian(answer.data, 0, 1);
      if ((status & kPowerError) != 0 && job_)
        emit(Message{"the printer reports a fault of its power supply"});
      emit(Temperatures{sensors_});  // asked last of a round
      return;
    }
    default:
      return;
  }
}

void Driver::on_tool_answer(const Answer& answer) {
  const std::string tool = "T" + std::to_string(static_cast<unsigned char>(answer.query.at(1)));
  const double value = static_cast<std::int16_t>(little_endian(answer.data, 0, 2));
  switch (static_cast<ToolQuery>(static_cast<unsigned char>(answer.query.at(2)))) {
    case ToolQuery::temperature:
      sensors_[tool].actual_c = value;
      return;
    case ToolQuery::target:
      sensors_[tool].target_c = value;
      return;
    case ToolQuery::bed_temperature:
      sensors_["B"].actual_c = value;
      return;
    case ToolQuery::bed_target:
      sensors_["B"].target_c = value;
      return;
    default:
      return;
  }
}

void Driver::on_build(const Answer& answer, double t) {
  const std::uint32_t line = little_endian(answer.data, 3, 4);
  if (glance_step_ == 1) {
    glance_.line = line;
    glance_step_ = 2;
  } else if (glance_step_ == 3) {
    glance_step_ = 0;
    if (line == glance_.line) link_.account().check(glance_);
  }
  // Said once it may be damage that the checksum does not show.
  if (std::exchange(build_line_, line) == line && std::exchange(progress_line_, line) != line)
    progress_t_ = t;
  build_ = static_cast<BuildState>(little_endian(answer.data, 0, 1));
  build_known_ = true;
  if (!job_) return;
  if (!job_->begun()) return;
  if (build_ == BuildState::running || build_ == BuildState::paused) {
    seen_running_ = true;
  } else if (build_ == BuildState::none && seen_running_) {
    return drop_job(PrintFailed{"the printer restarted in mid-print"});
  } else if (build_ == BuildState::cancelled && seen_running_ && !job_->ending()) {
    return on_refused({{}, ReplyCode::cancelled});
  }
  check_panel(t);
}

// Pause and resume are one button, here and at the panel.
void Driver::check_panel(double t) {
  const bool paused = build_ == BuildState::paused;
  if (paused == wants_paused_) {
    toggle_pending_ = false;
    return;
  }
  if (toggle_pending_ || t < toggled_t_ + kPauseSettles_s || !seen_running_ || job_->ending()) return;
  wants_paused_ = paused;
  if (paused) {
    job_->pause(true, "paused at the printer");
  } else {
    job_->resume();
  }
}

}  // namespace voidpath::fw::s3g
