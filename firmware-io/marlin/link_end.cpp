#include "firmware-io/marlin/link.h"

#include <algorithm>
#include <limits>

/// When a long command is over on a firmware whose ok says no more than that it is in the queue.
namespace voidpath::fw::marlin {
namespace {

// Its answer is nothing else's: Repetier's homing says where it is, its heating says temperatures, unasked.
constexpr std::string_view kEndQuestion = "M115";
// More would keep out what is urgent. Unanswered for long, the command is taken to be over.
constexpr int kMostEndQuestions = 2;

// One `wait` may have been said before the command came.
constexpr int kWaitsThatMeanDone = 2;

constexpr double kNever = std::numeric_limits<double>::infinity();

}  // namespace

bool Link::wants_end() const { return end_due_ && window_.may_send(kEndQuestion); }

void Link::ask_end(double t) {
  end_due_ = false;
  end_asked_t_ = t;
  waits_behind_ = 0;
  ++ends_asked_;
  ++ends_unanswered_;
  send(kEndQuestion, {}, t);
}

bool Link::on_name(double t) {
  if (ends_unanswered_ == 0) return false;
  // The others may be lost, or about to be answered as well.
  if (--ends_unanswered_ == 0)
    end_length(t);
  else
    end_heard_t_ = t;
  return true;
}

void Link::end_length(double t) {
  unfinished_ = 0;
  end_due_ = false;
  ends_unanswered_ = 0;
  end_heard_t_ = 0;
  note_progress(t);
}

double Link::ask_end_at() const {
  if (end_heard_t_ > 0) return end_heard_t_ + quiet_after_s();
  if (unfinished_ == 0 || end_due_ || held_ || !window_.idle()) return kNever;
  const double at_last = end_asked_t_ + timing_.long_silence_s;
  if (ends_asked_ >= kMostEndQuestions) return at_last;
  return std::min(std::max(received_t_, end_asked_t_) + timing_.silence_s, at_last);
}

// The answer was lost, or there is none.
void Link::end_unanswered(double t) {
  if (end_heard_t_ > 0 || ends_asked_ >= kMostEndQuestions)
    end_length(t);
  else
    end_due_ = true;
}

// It says `wait`: the answer was lost.
void Link::note_nothing_queued(double t) {
  if (unfinished_ > 0 && !end_due_ && window_.idle() && ++waits_behind_ >= kWaitsThatMeanDone) end_length(t);
}

}  // namespace voidpath::fw::marlin
