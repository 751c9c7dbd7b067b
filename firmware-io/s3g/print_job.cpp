#include "firmware-io/s3g/print_job.h"

#include "firmware-io/lines_of.h"

#include <exception>
#include <utility>

namespace voidpath::fw::s3g {
namespace {

/// How often the printer is asked whether it is at rest, s: this much later than true the end is noticed...
constexpr double kRestPoll_s = 0.02;
/// ...and whether a temperature is reached.
constexpr double kHeatPoll_s = 0.25;
/// So many asks at the beginning before the user is told what is waited for.
constexpr int kPatientAsks = 250;
/// Query::stop: both the motors and the queue.
constexpr std::uint8_t kStopAndClear = 3;

bool ends_build(const Action& action) {
  return static_cast<unsigned char>(action.payload.at(0)) == static_cast<unsigned char>(Command::build_end);
}

bool is_wait(const Action& action) {
  return action.kind == Action::Kind::wait_tool || action.kind == Action::Kind::wait_bed;
}

}  // namespace

PrintJob::PrintJob(std::unique_ptr<LineSource> source, Encoder& encoder, Endings endings, Emit emit)
    : source_(std::move(source)), encoder_(encoder), endings_(std::move(endings)), emit_(std::move(emit)) {}

std::optional<Question> PrintJob::question(double t) {
  if (!asks() || out_ || t < ask_t_) return {};
  const bool slow = wait_ == Wait::tool || wait_ == Wait::bed || heating_;
  ask_t_ = t + (slow ? kHeatPoll_s : kRestPoll_s);
  switch (wait_) {
    case Wait::none:
      return {};
    case Wait::rest:
      return s3g::question(Query::finished);
    case Wait::tool:
      return tool_question(wait_tool_, ToolQuery::ready);
    case Wait::bed:
      return tool_question(0, ToolQuery::bed_ready);
    case Wait::build:
      return s3g::question(Query::build);
    case Wait::board:
      return s3g::question(Query::board_status);
    case Wait::stopped:
      return Question{Payload(Query::stop).u8(kStopAndClear).bytes(), 0};
    case Wait::extruders:
    case Wait::position:
      return s3g::question(Query::position);
  }
  return {};
}

void PrintJob::on_answer(const Answer& answer, double t) {
  const bool yes = !answer.data.empty() && answer.data[0] == 1;
  std::array<std::int32_t, kAxes> steps{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    steps[i] = static_cast<std::int32_t>(little_endian(answer.data, 4 * i, 4));
  }
  const Query query = query_of(answer.query);
  const bool good = answer.code == ReplyCode::ok;
  if (held()) return;
  switch (wait_) {
    case Wait::none:
      return;
    case Wait::rest:
      if (query == Query::finished && yes) {
        rested();
      } else if (state_ == State::starting && ++rest_asks_ == kPatientAsks) {
        emit_(Message{"the print begins when the printer has done what it was sent before"});
      }
      ask_t_ = std::max(ask_t_, t);
      return;
    case Wait::tool:
    case Wait::bed:
      // Some firmware is "finished" while it waits, some is "ready" before it is done.
      if (query == Query::tool && (yes || !good)) wait_ = Wait::rest, ask_t_ = t;
      return;
    case Wait::extruders:
      if (query != Query::position) return;
      if (good) encoder_.set_extruders(steps[kA], steps[kB]);
      wait_ = Wait::none;
      state_ = State::feeding;
      return;
    case Wait::build:
      // Old firmware does not know the question.
      if (query == Query::build)
        on_build(good ? static_cast<BuildState>(answer.data.at(0)) : BuildState::done,
                 good ? little_endian(answer.data, 3, 4) : line_before_end_);
      return;
    // Whether the heaters still were on: the driver has looked. With no command left to refuse, a printer
    // that shut them down would only seem to have done everything.
    case Wait::board:
      if (query == Query::board_status) finish(PrintFinished{});
      return;
    case Wait::stopped:
      if (query != Query::stop) return;
      wants_abort_ = !good;
      wait_ = Wait::position;
      ask_t_ = t;
      return;
    case Wait::position:
      if (query != Query::position) return;
      if (good) encoder_.set_stand(steps);
      wait_ = Wait::none;
      queue_endings();
      return;
  }
}

// All that was sent is done.
void PrintJob::rested() {
  wait_ = Wait::none;
  drained_ = true;
  if (std::exchange(heating_, false)) {
    motion_armed_ = true;
    emit_(Heating{false});
  }
  if (state_ == State::starting) {
    wait_ = Wait::extruders;
  } else if (state_ == State::finishing && pending_.empty()) {
    wait_ = Wait::build;
  } else if (pending_.empty()) {
    advance();
    if (!pause_line_.empty()) pause(false, std::exchange(pause_line_, {}));
  }
}

void PrintJob::on_build(BuildState state, std::uint32_t line) {
  wait_ = Wait::none;
  if (state_ == State::starting) {
    if (state == BuildState::paused)
      return finish(PrintFailed{"the printer is paused in the middle of another print: end that one first"});
    pending_.push_back(encoder_.build_start("voidpath"));
    return;
  }
  // One that begins anew counts anew, and takes the build's end for that of one of its own.
  if (state == BuildState::none || line < line_before_end_)
    return end(std::move(endings_.cool), PrintFailed{"the printer restarted in mid-print"});
  build_seen_ = true;
  line_before_end_ = line;
  if (state_ != State::finishing || !pending_.empty()) return;
  if (state == BuildState::cancelled) {
    emit_(Message{"cancelled at the printer's panel"});
    return finish(PrintCancelled{});
  }
  wait_ = Wait::board;
  ask_t_ = 0;
}

std::optional<Action> PrintJob::next() {
  if (out_ || paused_ || wait_ != Wait::none) return {};
  if (state_ == State::feeding && pending_.empty()) fetch();
  if (pending_.empty() || paused_ || wait_ != Wait::none) return {};
  const Action& action = pending_.front();
  if (is_wait(action) && !drained_ && state_ != State::ending) {
    wait_ = Wait::rest;
    return {};
  }
  if (ends_build(action) && !build_seen_ && state_ != State::ending) {
    wait_ = Wait::build;
    ask_t_ = 0;
    return {};
  }
  if (state_ != State::starting && !std::exchange(started_, true)) emit_(PrintStarted{});
  if (is_wait(action) && !std::exchange(heating_, true)) emit_(Heating{true});
  if (action.kind == Action::Kind::move && std::exchange(motion_armed_, false)) emit_(MotionStarted{});
  drained_ = false;
  out_ = true;
  return action;
}

// Lines until one gives something to do.
void PrintJob::fetch() {
  try {
    while (state_ == State::feeding && !paused_ && wait_ == Wait::none && pending_.empty()) {
      const auto line = source_->next();
      if (!line) {
        if (encoder_.build_started()) pending_.push_back(encoder_.build_end());
        state_ = State::finishing;
        line_.reset();
        if (pending_.empty()) wait_ = Wait::rest;
        return;
      }
      take_line(*line);
    }
  } catch (const std::exception& error) {
    end(std::move(endings_.leave), PrintFailed{error.what()});
  }
}

void PrintJob::take_line(const SourceLine& line) {
  line_ = line;
  position_ = source_->position();
  Encoded encoded = encoder_.encode(line);
  for (const std::string& note : encoded.notes) emit_(Message{note});
  for (Action& action : encoded.actions) pending_.push_back(std::move(action));
  switch (encoded.host) {
    case Encoded::Host::pause:
      pause_line_ = line.text;
      wait_ = Wait::rest;
      return;
    case Encoded::Host::halt:
      wants_halt_ = true;
      return;
    case Encoded::Host::finish:
      wait_ = Wait::rest;
      return;
    case Encoded::Host::nothing:
    case Encoded::Host::report:
      if (pending_.empty()) advance();
      return;
  }
}

void PrintJob::on_accepted(const Accepted& accepted) {
  const Action& action = accepted.action;
  if (state_ == State::stopping) {
    out_ = false;
    return;
  }
  if (state_ == State::starting) {
    begun_ = true;
    wait_ = Wait::rest;
  } else if (action.kind == Action::Kind::home) {
    wait_ = Wait::rest;
  } else if (action.kind == Action::Kind::wait_tool && state_ != State::ending) {
    wait_ = Wait::tool;
    wait_tool_ = action.tool;
  } else if (action.kind == Action::Kind::wait_bed && state_ != State::ending) {
    wait_ = Wait::bed;
  }
  advance();
}

// The front action is dealt with, or a line without any.
void PrintJob::advance() {
  if (std::exchange(out_, false) && !pending_.empty()) pending_.pop_front();
  if (!pending_.empty() || wait_ != Wait::none) return;
  if (line_) {
    emit_(LineDone{line_->index, position_});
    line_.reset();
  }
  if (state_ == State::finishing) wait_ = Wait::rest;
  if (state_ == State::ending) finish(*outcome_);
}

void PrintJob::finish(decltype(Event::what) outcome) {
  state_ = State::over;
  emit_(std::move(outcome));
}

void PrintJob::drop(decltype(Event::what) outcome) {
  if (state_ != State::over) finish(std::move(outcome));
}

void PrintJob::pause(bool by_printer, const std::string& reason) {
  if (paused_ || ending()) return;
  paused_ = true;
  emit_(Paused{by_printer, reason});
}

void PrintJob::resume() {
  if (!paused_ || ending()) return;
  paused_ = false;
  ask_t_ = 0;
  emit_(Resumed{});
}

void PrintJob::end(std::vector<std::string> lines, decltype(Event::what) outcome) {
  if (state_ >= State::stopping) return;
  // Nothing of it is in the printer, which may be at something else.
  if (state_ == State::starting && !begun_ && !out_) return finish(std::move(outcome));
  ending_lines_ = std::move(lines);
  outcome_ = std::move(outcome);
  pending_.clear();
  line_.reset();
  paused_ = false;
  state_ = State::stopping;
  wait_ = Wait::stopped;
  ask_t_ = 0;
}

void PrintJob::queue_ending(std::string_view line) {
  try {
    for (Action& action : encoder_.encode(line).actions) pending_.push_back(std::move(action));
  } catch (const EncodeError& error) {
    emit_(Message{error.what()});
  }
}

void PrintJob::queue_endings() {
  state_ = State::ending;
  queue_ending("G21");  // whatever the file's unit was
  for (const std::string& text : ending_lines_)
    for (const std::string_view line : lines_of(text)) queue_ending(line);
  if (encoder_.build_started()) pending_.push_back(encoder_.build_end());
  if (pending_.empty()) finish(*outcome_);
}

}  // namespace voidpath::fw::s3g
