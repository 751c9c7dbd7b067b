#include "firmware-io/marlin/print_job.h"

#include "firmware-io/heaters_off.h"
#include "firmware-io/lines_of.h"
#include "firmware-io/marlin/file_command.h"
#include "firmware-io/marlin/words.h"

#include <algorithm>
#include <exception>
#include <limits>
#include <stdexcept>
#include <utility>

namespace voidpath::fw::marlin {
namespace {

// Answered by a bare ok each time: then this firmware says no temperatures, or ever so many oks came twice.
constexpr int kVerifications = 50;

/// What of a line's meaning decides when it and what follows may go.
struct Meaning {
  bool pauses = false;
  bool is_left_out = false;
  bool heats = false;
  bool is_long = false;
  bool holds_back = false;
  int unit = 0;  ///< 20: inches from here on, 21: millimetres
};

int unit_of(std::string_view text) {
  const Word word = first_word(text);
  return word == Word{'G', 20} || word == Word{'G', 21} ? word.number : 0;
}

Meaning meaning_of(std::string_view text) {
  // Nearly every line is a plain move.
  if (text.starts_with("G1 ") || text.starts_with("G0 ")) return {};
  return {is_pause(text),
          sets_keepalive(text) || sets_reports(text),
          is_heating_wait(text),
          is_long(text),
          is_homing(text) || may_wait_for_person(text) || is_macro(text),
          unit_of(text)};
}

}  // namespace

PrintJob::PrintJob(std::unique_ptr<LineSource> source, const FirmwareInfo& firmware, Emit emit)
    : source_(std::move(source)), firmware_(firmware), emit_(std::move(emit)) {}

// True when pending_ is the next line; false at the end of the file.
bool PrintJob::fetch() {
  if (!is_pending_) {
    is_pending_ = source_->fetch(pending_);
    pending_position_ = source_->position();
  }
  return is_pending_;
}

void PrintJob::note_sent(const Tag& tag, const std::string& text) {
  if (!std::exchange(started_, true)) emit_(PrintStarted{});
  if (tag.heating) {
    heating_ = true;
    emit_(Heating{true});
  } else if (tag.holds_back) {
    held_back_ = true;
  } else if (motion_armed_ && is_motion(text)) {
    motion_armed_ = false;
    emit_(MotionStarted{});
  }
}

PrintJob::Step PrintJob::feed_line(Link& link, double t) {
  // What comes after a wait or a homing is held back until that has ended, so that the first motion goes out,
  // and is timed, when it can begin.
  // And what ends a wait for a person is only read while the firmware's queue has room.
  if (heating_ || held_back_) return Step::wait;
  if (!fetch()) {
    if (!link.may_send("M400")) return Step::wait;
    if (!std::exchange(started_, true)) emit_(PrintStarted{});
    link.send("M400", {.kind = Tag::Kind::finish, .is_long = true}, t);
    state_ = State::finishing;
    return Step::wait;
  }
  const std::string& text = pending_.text;
  const Meaning meaning = meaning_of(text);
  if (meaning.pauses) {
    is_pending_ = false;
    pause(false, text);
    return Step::wait;
  }
  if (meaning.is_left_out) {
    is_pending_ = false;
    return Step::sent;
  }
  const bool may_go = text.starts_with('G') && !meaning.is_long ? link.may_begin(text) : link.may_send(text);
  if (!may_go || (meaning.heats && !link.all_acknowledged())) return Step::wait;
  const Tag tag{Tag::Kind::file, pending_.index,  pending_position_,
                meaning.heats,   meaning.is_long, meaning.holds_back};
  link.send(text, tag, t);
  is_pending_ = false;
  if (meaning.unit != 0) inches_ = meaning.unit == 20;
  note_sent(tag, text);
  return Step::sent;
}

void PrintJob::feed_ending(Link& link, double t) {
  // One at a time: an emergency stop behind a cancel must find room, too.
  while (!ending_lines_.empty() && !link.waits_at_length() && link.may_send(ending_lines_.front())) {
    const std::string& text = ending_lines_.front();
    link.send(text, {.kind = Tag::Kind::ending, .is_long = true}, t);  // waits for the moves before it
    ending_lines_.pop_front();
  }
}

void PrintJob::feed(Link& link, double t) {
  if (state_ == State::verifying) return verify(link, t);
  if (state_ == State::ending) return feed_ending(link, t);
  try {
    while (state_ == State::feeding && feed_line(link, t) == Step::sent) {
    }
  } catch (const std::exception& error) {
    end(heaters_off(firmware_), PrintFailed{error.what()}, link, t);
    feed_ending(link, t);
  }
}

void PrintJob::finish() {
  state_ = State::over;
  emit_(PrintFinished{});
}

void PrintJob::verify(Link& link, double t) {
  if (!link.all_acknowledged() || t < deadline(link)) return;
  if (answered_) return finish();
  if (++verifications_ > kVerifications) return finish();  // a firmware whose M105 says no temperatures
  link.send("M105", {}, t);
}

double PrintJob::deadline(const Link& link) const noexcept {
  if (state_ != State::verifying || !link.all_acknowledged()) return std::numeric_limits<double>::infinity();
  return verifications_ == 0 ? heard_t_ : heard_t_ + link.quiet_after_s();
}

void PrintJob::on_ok(const Link& link, bool temperatures, double t) {
  heard_t_ = t;
  if (state_ != State::verifying || verifications_ == 0) return;
  answered_ = temperatures && link.all_acknowledged();
  if (answered_ && verifications_ == 1 && link.questions_answered()) finish();
}

void PrintJob::on_acknowledged(const Tag& tag) {
  if (tag.holds_back) held_back_ = false;
  if (tag.heating) {
    heating_ = false;
    motion_armed_ = true;
    emit_(Heating{false});
  }
  if (tag.kind == Tag::Kind::file) emit_(LineDone{tag.index, tag.file_position});
  if (tag.kind == Tag::Kind::finish && state_ == State::finishing) state_ = State::verifying;
  if (tag.kind == Tag::Kind::ending && --ending_unacknowledged_ == 0) {
    state_ = State::over;
    emit_(*outcome_);
  }
}

void PrintJob::pause(bool by_printer, const std::string& reason) {
  if (!goes_on() || (at_end() && !by_printer)) return;
  if (at_end())
    waits_at_end_ = true;
  else
    state_ = State::paused;
  emit_(Paused{by_printer, reason});
}

void PrintJob::resume() {
  if (std::exchange(waits_at_end_, false)) return emit_(Resumed{});
  if (state_ != State::paused) return;
  state_ = State::feeding;
  emit_(Resumed{});
}

// None of them may keep those behind it from being sent: they turn the heaters off.
void PrintJob::queue_ending(std::string_view line) {
  try {
    std::string command = file_command(line);
    if (!command.empty() && !is_pause(command)) ending_lines_.push_back(std::move(command));
  } catch (const std::runtime_error& error) {
    emit_(Message{"left out at the end of the print: " + std::string(error.what())});
  }
}

void PrintJob::end(const std::vector<std::string>& lines, decltype(Event::what) outcome, Link& link,
                   double t) {
  if (state_ == State::ending || state_ == State::over) return;
  state_ = State::ending;
  if (heating_) link.send_raw("M108", true, t);  // else the wait would go on for minutes
  if (inches_) queue_ending("G21");              // in which `lines` are written
  for (const std::string& text : lines)
    for (const std::string_view line : lines_of(text)) queue_ending(line);
  ending_unacknowledged_ = ending_lines_.size();
  const std::vector<std::string> off = heaters_off(firmware_);
  const auto last = std::find_first_of(ending_lines_.rbegin(), ending_lines_.rend(), off.begin(), off.end());
  if (last != ending_lines_.rend()) behind_heaters_ = static_cast<std::size_t>(last - ending_lines_.rbegin());
  outcome_ = std::move(outcome);
}

}  // namespace voidpath::fw::marlin
