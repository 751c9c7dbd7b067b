#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Which line may be sent now: the send window of Marlin's numbered dialogue. Pure: no I/O, no clock.
///
/// Notation. A line has a number; `next` is the number the next new line gets. In flight is what was sent
/// and not yet acknowledged, oldest first. `cursor` < next while lines must be sent again.
///
/// What is known of the firmware. It takes line n only after n-1, counts n as taken when it reads it, and
/// says ok when it has executed it. A damaged line makes it drop everything in its receive buffer and ask for
/// the next number it wants; every complete line arriving behind makes it ask again. The ok that ends such a
/// request belongs to it and may overtake the oks still owed for earlier lines; some firmware never says it.
/// A line that repeats the last or last but one taken is met with silence. After a boot it wants the first
/// line, whatever it is sent.
///
/// How much may be out. After a request: one line, then
/// twice as much with each round up to half of what was out, then a byte more with each ok up to the ceiling.
/// The ceiling is max_bytes until requests follow one another so quickly that damage on the wire cannot be
/// it: then the receive buffer is smaller than was said, or something else writes into it. It is lowered and
/// creeps up again. Where the oks count the free places of the command queue (ADVANCED_OK), lines standing in
/// that queue no longer count: they have left the receive buffer.
///
/// Exactly once needs the numbers alone; the acknowledgements only pace. A lost or doubled ok therefore
/// costs time or moves an acknowledgement by a line, never a line.
namespace voidpath::fw::marlin {

struct WindowOptions {
  int max_bytes = 127;         ///< unacknowledged bytes, newlines included: receive ring minus one
  int stuck_rounds = 10;       ///< so many requests for one line in a row: it cannot pass
  int silent_stalls = 5;       ///< so many stalls in a row: nobody is there
  std::size_t history = 1024;  ///< lines kept for resending
};

class Window {
 public:
  enum class Health {
    good,
    stuck,       ///< one line is refused for ever
    no_history,  ///< asked for a line no longer kept, or never sent, again and again
    silent,      ///< no answer in spite of probing
    restarted,   ///< wants the dialogue from its beginning: it has booted, unheard
  };

  explicit Window(WindowOptions options = {});

  /// After `M110 N<last>` was taken: nothing in flight, the next line is last + 1.
  void restart(std::uint32_t last);

  // --- sending ---

  /// True when a new line of this payload may go out now.
  bool may_send(std::string_view payload) const;
  /// True when at least its beginning may: in pieces the limit is always used to the last byte.
  bool may_begin(std::string_view payload) const;
  /// Numbers, keeps and frames a new line; may_begin() must hold, and may_send() where it is to go whole.
  /// Stands until the next call of anything here.
  const std::string& send(std::string_view payload);
  /// So many bytes at the end of the last line are not out. Nothing else may go before them.
  int withheld() const noexcept { return withheld_; }
  /// So many of them may go now, and count as out.
  int let_out();
  /// They go whatever the limit says, or never: then a newline must end what is out of the line.
  void end_line() noexcept { withheld_ = 0; }
  /// Whether moves may be begun where they don't fit: for firmware that refuses what is cut off.
  void set_piecewise(bool on) noexcept { piecewise_ = on; }
  /// That line, or the one of the last resend(), as a firmware reads it, whether packed or not.
  const std::string& text() const noexcept { return packing_ ? unpacked_ : framed_; }
  /// From now on moves go without blanks, as far as lines are not packed.
  void set_dense(bool on) noexcept { dense_ = on; }
  /// From now on lines are packed (meatpack.h) and counted as what they then fill.
  void set_packing(bool on) noexcept { packing_ = on; }
  bool packing() const noexcept { return packing_; }
  /// A line the firmware wants again, framed, if there is one and it may go out now.
  std::optional<std::string> resend();
  /// An unnumbered line that will be answered by an ok went out.
  void sent_unnumbered();
  /// True when a question may go out after a silence in which all that was sent has arrived: what then stands
  /// in the command queue has left the receive buffer, whatever oks were lost.
  bool may_ask(std::string_view question) const;
  /// The next line is that question: it may go beyond the limit.
  void allow_question() noexcept { question_ = true; }

  // --- what the printer says; each line of it is reported by exactly one of these ---

  /// `queue_free`: the B of ADVANCED_OK.
  /// `temperatures`: only M105 is answered so, hence the first of them in flight and all before it.
  void on_ok(std::optional<std::uint32_t> line, std::optional<int> queue_free = {},
             bool temperatures = false);
  void on_resend(std::uint32_t line);
  /// What only the first line brings about was seen: who wants it from now on has booted.
  void on_first_line_taken() noexcept { first_taken_ = true; }
  void on_framing_error(std::optional<std::uint32_t> last_line);
  void on_other_line();
  /// The firmware says that its receive buffer ran over.
  void on_overrun();

  // --- what the clock says ---

  /// After a resend request the line has been quiet long enough for nothing more to come.
  void on_quiet();
  /// No ok for a while though the window is not full: one more line can do no harm. What answers_missing()
  /// means counts as answered.
  void on_patience();
  /// No ok for so long that one must have been lost, or that nobody is there. Lets one line out to provoke an
  /// answer, unless it may not; beyond the limit if the ring may be overfilled for it.
  void on_stall(bool may_overfill = true, bool may_probe = true);
  /// It is at work, whatever oks are missing: stalls alone no longer tell that nobody is there.
  void on_life() noexcept;

  // --- state ---

  bool draining() const noexcept { return draining_; }
  bool resending() const noexcept { return cursor_ < next_; }
  /// Nothing in flight and nothing to send again.
  bool idle() const noexcept { return in_flight_.empty() && withheld_ == 0 && !resending() && !draining_; }
  bool waiting() const noexcept { return !in_flight_.empty(); }
  /// A stall was met by permission for one line which nobody has used yet.
  bool wants_probe() const noexcept { return grant_; }
  /// Lines let out, or meant to be, since the last ok.
  int stalls() const noexcept { return stalls_; }
  /// The line let out by a stall was answered: if it now stays quiet, all before it had been taken.
  bool probe_was_answered() const noexcept { return probing_ && probe_answered_; }
  bool throttled() const noexcept { return limit_ < patient_limit(); }
  /// So many questions are out, whose answers cannot be mistaken for another line's.
  int questions() const;
  bool asking() const { return questions() > 0; }
  /// Only questions are out, and one was answered since the last line was sent.
  bool answers_missing() const;
  /// Lines acknowledged by such an answer instead of by their own oks.
  std::uint64_t lost_oks() const noexcept { return lost_oks_; }
  /// Highest number acknowledged; never falls.
  std::uint32_t acknowledged() const noexcept { return acknowledged_; }
  std::uint32_t next_number() const noexcept { return next_; }
  /// The next line to go out; resend() moves it.
  std::uint32_t cursor() const noexcept { return cursor_; }
  /// The oldest line that is still kept.
  std::uint32_t first_kept() const noexcept { return first_kept_; }
  /// The payload of a line not longer ago than the history.
  const std::string& kept(std::uint32_t number) const { return history_[number % history_.size()]; }
  int limit_bytes() const noexcept { return limit_; }
  int ceiling_bytes() const noexcept { return ceiling_; }
  /// What is withheld of them included.
  int bytes_in_flight() const noexcept { return bytes_in_flight_; }
  std::uint64_t resend_requests() const noexcept { return resend_requests_; }
  /// Requests for a line that had been acknowledged: a sign of a line run without its number.
  std::uint64_t doubtful_requests() const noexcept { return doubtful_requests_; }
  /// Oks of a firmware that names the line, naming none: it has obeyed something unnumbered.
  std::uint64_t nameless_oks() const noexcept { return nameless_oks_; }
  Health health() const noexcept { return health_; }

 private:
  /// How the ceiling comes back: a byte each so many oks, four times as slowly after each lowering.
  static constexpr int kCreepFastest_oks = 16;

  struct Flight {
    std::uint32_t number = 0;  ///< 0: unnumbered
    int bytes = 0;             ///< in the receive ring, 0 once known to have left it
    bool question = false;     ///< M105
  };

  const std::string& encode(std::uint32_t number, std::string_view payload) const;
  bool has_room_for(std::string_view payload) const;
  bool has_room(int bytes) const noexcept;
  bool wants_the_beginning(std::uint32_t line);
  void note_sent(std::uint32_t number, std::size_t bytes);
  void use_grant() noexcept;
  void acknowledge_front();
  void acknowledge_all();
  void note_all_taken() noexcept;
  void rewind_to(std::uint32_t line);
  int patient_limit() const noexcept;
  void grow(int bytes);
  void restrain();
  void lower_ceiling();
  void leave_ring(int lines);
  void give_up(Health why) noexcept {
    if (health_ == Health::good) health_ = why;
  }
  std::string& slot(std::uint32_t number) { return history_[number % history_.size()]; }

  WindowOptions options_;
  std::vector<std::string> history_;  ///< ring of payloads by number
  mutable std::string framed_;        ///< the last line encoded; kept for its memory
  mutable std::string unpacked_;      ///< the same before it was packed
  std::deque<Flight> in_flight_;
  std::uint32_t first_ = 1;   ///< of the dialogue
  bool first_taken_ = false;  ///< for sure: an ok alone may be one too many
  std::uint32_t first_kept_ = 1;
  std::uint32_t next_ = 1;
  std::uint32_t cursor_ = 1;
  std::uint32_t acknowledged_ = 0;
  std::uint32_t cut_off_ = 0;  ///< the last line, begun and broken off and not yet sent again; 0: none
  int bytes_in_flight_ = 0;
  int withheld_ = 0;
  int limit_;
  int threshold_;                      ///< up to here the limit doubles, beyond it creeps
  int ceiling_;                        ///< the limit's own limit
  int creep_oks_ = kCreepFastest_oks;  ///< so many raise a lowered ceiling by a byte
  int oks_ = 0;                        ///< since the limit stands at the ceiling
  int early_requests_ = 0;             ///< in a row
  int queue_places_ = 0;               ///< the most ever reported free
  bool counts_trusted_ = true;
  bool dense_ = false;
  bool piecewise_ = false;
  bool packing_ = false;
  bool draining_ = false;
  bool grant_ = false;
  bool question_ = false;
  bool answered_ = false;  ///< a question, since the last line was sent
  bool probing_ = false;   ///< the granted line went out
  bool probe_answered_ = false;
  bool resent_was_in_flight_ =
      false;                  ///< the line asked for had just been sent again: it may have been taken
  int request_ok_due_ = 0;    ///< the ok among the next so many lines belongs to a request
  int request_oks_seen_ = 0;  ///< learns whether this firmware says it
  int request_oks_missed_ = 0;
  std::uint32_t round_line_ = 0;
  int rounds_ = 0;
  int impossible_ = 0;
  int restart_signs_ = 0;  ///< in a row
  int stalls_ = 0;
  std::uint64_t resend_requests_ = 0;
  std::uint64_t doubtful_requests_ = 0;
  std::uint64_t nameless_oks_ = 0;
  std::uint64_t lost_oks_ = 0;
  Health health_ = Health::good;
};

}  // namespace voidpath::fw::marlin
