#pragma once

#include "firmware-io/event.h"
#include "firmware-io/line_source.h"
#include "firmware-io/marlin/link.h"

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace voidpath::fw::marlin {

/// Emits an event, stamped with the session clock's present time.
using Emit = std::function<void(decltype(Event::what))>;

/// One print: pulls lines from the source into the link, and ends it, well or not. One thread.
///
/// A heating wait goes out only when everything before it is acknowledged, and nothing follows until it is
/// acknowledged itself: so its beginning and end are known, and the first motion leaves right after it.
///
/// The file's end is M400, and then M105, whose number is only taken when all before it were: a bare ok may
/// have come twice and stand for a line too many. An answer of M105 cannot be mistaken for another line's,
/// but for that of another M105. So where it is not the only one whose answer is awaited, or oks have come in
/// its place, it is asked after a silence and its answer must be followed by one.
class PrintJob {
 public:
  /// `firmware` stands as long as the job.
  PrintJob(std::unique_ptr<LineSource> source, const FirmwareInfo& firmware, Emit emit);

  /// Sends what may go now.
  void feed(Link& link, double t);
  void on_acknowledged(const Tag& tag);
  /// An ok came, or temperatures where they stand for M105's.
  void on_ok(const Link& link, bool temperatures, double t);
  /// When feed() is to be called though nothing comes.
  double deadline(const Link& link) const noexcept;

  void pause(bool by_printer, const std::string& reason);
  void resume();
  /// Ends the file here and sends `lines` instead, written as in a file, in millimetres; `outcome` is emitted
  /// when they are acknowledged. A second call changes nothing.
  void end(const std::vector<std::string>& lines, decltype(Event::what) outcome, Link& link, double t);

  bool over() const noexcept { return state_ == State::over; }
  bool ending() const noexcept { return state_ == State::ending; }
  /// The lines that turn the heaters off have been acknowledged.
  bool cold() const noexcept { return ending() && ending_unacknowledged_ <= behind_heaters_; }
  /// Neither paused nor ended: a wait of the printer is news.
  bool goes_on() const noexcept { return state_ == State::feeding || (at_end() && !waits_at_end_); }
  bool paused() const noexcept { return state_ == State::paused; }
  /// Nothing but the last answers is waited for: a lost one would be met by no line behind it.
  bool at_end() const noexcept { return state_ == State::finishing || state_ == State::verifying; }
  bool heating() const noexcept { return heating_; }

 private:
  enum class State { feeding, paused, finishing, verifying, ending, over };
  enum class Step { sent, wait };

  bool fetch();
  Step feed_line(Link& link, double t);
  void queue_ending(std::string_view line);
  void feed_ending(Link& link, double t);
  void verify(Link& link, double t);
  void note_sent(const Tag& tag, const std::string& text);
  void finish();

  std::unique_ptr<LineSource> source_;
  const FirmwareInfo& firmware_;
  Emit emit_;
  State state_ = State::feeding;
  SourceLine pending_;  ///< the next line, once fetched; else an old one, for its memory
  bool is_pending_ = false;
  std::uint64_t pending_position_ = 0;
  bool waits_at_end_ = false;  ///< the printer, for a person, though all is sent
  int verifications_ = 0;      ///< M105 sent behind M400
  bool answered_ = false;      ///< and nothing but silence since
  double heard_t_ = 0;         ///< an ok, last
  bool started_ = false;
  bool heating_ = false;      ///< a heating wait is out
  bool held_back_ = false;    ///< by a homing, a probing, a macro or a wait for a person that is out
  bool inches_ = false;       ///< the file's unit, as far as it was sent
  bool motion_armed_ = true;  ///< no motion since the start or the last heating wait
  std::deque<std::string> ending_lines_;
  std::size_t behind_heaters_ = 0;  ///< ending lines behind those that turn them off
  std::size_t ending_unacknowledged_ = 0;
  std::optional<decltype(Event::what)> outcome_;
};

}  // namespace voidpath::fw::marlin
