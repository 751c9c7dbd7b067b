#pragma once

#include "firmware-io/event.h"
#include "firmware-io/line_source.h"
#include "firmware-io/s3g/encoder.h"
#include "firmware-io/s3g/link.h"

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace voidpath::fw::s3g {

/// Emits an event, stamped with the session clock's present time.
using Emit = std::function<void(decltype(Event::what))>;

/// One print: turns the source's lines into actions one after the other, and ends it, well or not. One
/// thread.
///
/// It begins with a build notification, which a printer at a print of its own refuses; a paused one would not
/// come to it. The file follows when what an earlier session left behind is done. A heating wait goes out
/// when all before it is done, and nothing follows a wait or a homing until that has ended: so that both are
/// timed, and the first motion leaves when it can begin. At the end of the file the printer is asked until it
/// is at rest. A printer that restarted takes what follows as if nothing were: it knows of no build, which is
/// asked before the build is ended, and again when all is done.
class PrintJob {
 public:
  /// Lines that end a print which cannot go on.
  struct Endings {
    std::vector<std::string> leave;
    std::vector<std::string> cool;  ///< the heaters alone, where nobody knows where it stands
  };

  PrintJob(std::unique_ptr<LineSource> source, Encoder& encoder, Endings endings, Emit emit);

  /// What must be known before anything more is sent; at most once a poll.
  std::optional<Question> question(double t);
  double next_question_t() const noexcept { return asks() && !out_ ? ask_t_ : kNever_t; }
  void on_answer(const Answer& answer, double t);
  /// The next action to send; empty while there is none.
  std::optional<Action> next();
  void on_accepted(const Accepted& accepted);
  /// Left out: this firmware does not know it.
  void on_left_out() { advance(); }
  /// What next() gave was not sent after all; end() follows.
  void take_back() noexcept { out_ = false; }

  void pause(bool by_printer, const std::string& reason);
  void resume();
  /// Stops what moves and is queued, then runs `lines`, written as in a file; `outcome` is emitted when they
  /// are queued. A second call changes nothing.
  void end(std::vector<std::string> lines, decltype(Event::what) outcome);
  /// Over at once, with that outcome.
  void drop(decltype(Event::what) outcome);

  bool over() const noexcept { return state_ == State::over; }
  bool ending() const noexcept { return state_ >= State::stopping; }
  /// Ends, and what moves is still to be stopped.
  bool stopping() const noexcept { return state_ == State::stopping; }
  bool paused() const noexcept { return paused_; }
  /// The printer has been told of it.
  bool begun() const noexcept { return begun_; }
  bool wants_halt() const noexcept { return wants_halt_; }
  /// The printer cannot be stopped politely.
  bool wants_abort() const noexcept { return wants_abort_; }
  const decltype(Event::what)& outcome() const { return *outcome_; }

 private:
  enum class State { starting, feeding, finishing, stopping, ending, over };
  enum class Wait { none, rest, tool, bed, extruders, build, board, stopped, position };
  static constexpr double kNever_t = 1e300;

  bool asks() const noexcept { return state_ != State::over && wait_ != Wait::none && !held(); }
  /// Begins and ends no print while it is paused, nor pauses it a second time: the printer may be at rest
  /// because of that.
  bool held() const noexcept { return paused_ && (state_ != State::feeding || !pause_line_.empty()); }
  void fetch();
  void take_line(const SourceLine& line);
  void advance();
  void rested();
  void on_build(BuildState state, std::uint32_t line);
  void queue_endings();
  void queue_ending(std::string_view line);
  void finish(decltype(Event::what) outcome);

  std::unique_ptr<LineSource> source_;
  Encoder& encoder_;
  Endings endings_;
  Emit emit_;
  State state_ = State::starting;
  Wait wait_ = Wait::build;
  int wait_tool_ = 0;
  bool drained_ = false;
  bool build_seen_ = false;            ///< still the printer's when its end was due
  std::uint32_t line_before_end_ = 0;  ///< the printer's count of commands then
  double ask_t_ = 0;
  int rest_asks_ = 0;  ///< before it began
  std::deque<Action> pending_;
  bool out_ = false;  ///< the front one is on its way
  std::optional<SourceLine> line_;
  std::string pause_line_;  ///< the file's, once all before it is done
  std::uint64_t position_ = 0;
  bool begun_ = false, started_ = false;
  bool paused_ = false;
  bool heating_ = false;
  bool motion_armed_ = true;  ///< no motion since the start or the last heating wait
  bool wants_halt_ = false, wants_abort_ = false;
  std::vector<std::string> ending_lines_;
  std::optional<decltype(Event::what)> outcome_;
};

}  // namespace voidpath::fw::s3g
