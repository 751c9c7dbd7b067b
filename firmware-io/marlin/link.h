#pragma once

#include "firmware-io/clock.h"
#include "firmware-io/flight_recorder.h"
#include "firmware-io/marlin/reply.h"
#include "firmware-io/marlin/window.h"

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace voidpath::fw::marlin {

/// Protocol times in seconds of the steady clock, which is handed in as `t`.
struct Timing {
  double quiet_s = 0.05;      ///< after a resend request, beyond twice the round trip: USB bridges hold 16 ms
  double patience_s = 0.25;   ///< without an ok, before a throttled window opens and M105 is asked
  double silence_s = 30;      ///< without an ok, from a firmware that says no `busy`
  double busy_silence_s = 6;  ///< the same from one that says it every 2 s
  double long_silence_s = 900;  ///< a levelling run without `busy`
  double ask_again_s = 60;      ///< during one that says something, when two M105 are out
  double probe_s = 1;           ///< after a probe was answered: nothing else was owed
};

/// What a numbered line was for; handed back when it is acknowledged.
struct Tag {
  enum class Kind { file, control, resume, query, finish, ending };
  Kind kind = Kind::control;
  std::uint32_t index = 0;
  std::uint64_t file_position = 0;
  bool heating = false;
  bool is_long = false;
  bool holds_back = false;  ///< what follows
};

/// The numbered dialogue with its timers: the window, what is to be written, what comes back. No I/O.
/// One thread.
class Link {
 public:
  Link(WindowOptions options, Timing timing, double byte_s, const Clock& stamp, FlightRecorder& recorder);

  /// Numbers begin after `last`; all that was outstanding is forgotten.
  void restart(std::uint32_t last);
  /// The time from a line to its answer while the printer did nothing else; the least of them counts.
  void learn_round_trip(double seconds) noexcept;
  void forget_round_trip() noexcept;

  /// From now on lines go packed: the firmware said it understands.
  void start_packing() noexcept { window_.set_packing(true), packed_once_ = true, quiet_lines_ = 0; }
  /// A request or a stall ended the packing: damage that no checksum shows is likelier in packed lines. True
  /// when so many lines have gone well since that it may be tried again.
  bool packing_due() const noexcept;
  /// The firmware was told to unpack, and may have heard it whatever it answers.
  void packing_tried() noexcept { packed_once_ = true; }
  /// It was tried and not answered.
  void packing_failed() noexcept { quiet_lines_ = 0; }
  bool packing() const noexcept { return window_.packing(); }
  /// Whether moves go without blanks where they are not packed.
  void set_dense(bool on) noexcept { window_.set_dense(on); }
  /// Whether a colon ends a line, as in firmware before Marlin 1.1: then a point goes in its place.
  void set_colon_ends_line(bool on) noexcept { colon_ends_line_ = on; }
  /// Whether an ok says "in the queue": then a long command is over, and acknowledged, when a question behind
  /// it has been answered.
  void set_ok_at_enqueue(bool on) noexcept { ok_at_enqueue_ = on; }
  /// After all was forgotten: nothing is packed.
  void forget_packing() noexcept { window_.set_packing(false), packed_once_ = false; }
  /// Until then oks may be left lying: when the last one has come that comes before the wire runs dry, so
  /// that one awakening serves for as many as can be. 0: not at all.
  double rest_until() noexcept;
  /// A rest that was to end at `until` ended at `t`.
  void note_rested(double until, double t) noexcept;
  /// The answer to the first line came, whatever became of its ok.
  void first_line_answered() noexcept { window_.on_first_line_taken(); }
  /// Whether moves may go in pieces, so that the printer's receive buffer is always full.
  void set_piecewise(bool on) noexcept { window_.set_piecewise(on); }
  bool may_send(std::string_view payload) const;
  bool may_begin(std::string_view payload) const { return unfinished_ == 0 && window_.may_begin(payload); }
  void send(std::string_view payload, Tag tag, double t);
  /// Without a number. `answered`: an ok comes back for it. A line begun before is sent to its end, or ended
  /// where it is by a newline that `text` begins with.
  void send_raw(std::string_view text, bool answered, double t);
  /// What was to be written is not: the port is closed, or all is over.
  void drop_output();
  /// Sends the end of a line begun and what was asked for again, as far as they may go.
  void pump(double t);

  void on_reply(const Reply& reply, double t);
  /// Temperatures, from a firmware that says them unasked only while it waits: it has read a question and all
  /// before it, whatever became of their oks.
  void on_answer_apart(double t);
  /// The firmware lives and works: the stall timers start again.
  void note_progress(double t) { progress_t_ = t, held_ = false; }
  /// Waits for a person: no timers until it goes on.
  void hold() { held_ = true; }
  /// Waits for a temperature, perhaps because the person was away for long. Who says no `busy` does not say
  /// either that the person is waited for again.
  void note_heating(double t) {
    const bool held = held_ && !busy_seen_;
    note_progress(t);
    held_ = held;
  }
  /// The firmware says `busy` by itself.
  void note_busy(double t) {
    busy_seen_ = true;
    window_.on_life();
    if (window_.asking() || long_outstanding()) silent_since_t_ = t;
    note_progress(t);
  }

  /// It may be silent from now on.
  void forget_busy() noexcept { busy_seen_ = false; }

  /// That question is to be sent.
  bool wants_end() const;
  void ask_end(double t);
  /// The firmware said its name; false where that was no answer to ask_end().
  bool on_name(double t);

  std::optional<Tag> take_acknowledged();
  double deadline() const;
  void elapsed(double t);

  bool all_acknowledged() const noexcept { return window_.idle(); }
  /// A long command may be out: what is sent now stands in the firmware's queue until it is over.
  bool waits_at_length() const noexcept {
    return unfinished_ > 0 || (may_be_at_length() && window_.waiting());
  }
  /// Every M105 that was sent has had an answer of its own, as far as answers can be told apart: whatever was
  /// acknowledged, by an ok too many, is another matter.
  bool questions_answered() const noexcept { return questions_open_ == 0; }
  /// After what was heard last, so long a silence means that nothing more is on its way.
  double quiet_after_s() const noexcept;
  /// An ok may have been lost: M105's answer tells what was taken. At most one is out while answers come.
  bool wants_question() const;
  /// Sends it.
  void ask(double t);
  /// A line is needed to provoke an answer, and nobody sent one.
  bool wants_probe() const noexcept { return window_.wants_probe() && !window_.draining(); }
  double progress_t() const noexcept { return progress_t_; }
  const Window& window() const noexcept { return window_; }
  std::string& output() noexcept { return output_; }
  std::uint64_t lines_sent() const noexcept { return lines_sent_; }
  std::uint64_t bytes_sent() const noexcept { return bytes_sent_; }

 private:
  struct Outstanding {
    std::uint32_t number = 0;
    Tag tag;
    double gone_t = 0;  ///< when its last byte has gone, as estimated; infinite before that is written
    double earliest_gone_t = 0;  ///< the same on the fastest wire of that name
  };
  bool loses_colons(std::string_view payload) const {
    return colon_ends_line_ && payload.find(':') != payload.npos;
  }
  void put(std::string_view bytes, double t);
  void write(std::string_view bytes, std::string_view shown, double t);
  void let_out(std::size_t bytes, double t);
  void end_line(double t);
  void break_line();
  void stop_packing();
  double drained_at() const noexcept;
  bool long_outstanding() const noexcept;
  bool may_be_at_length() const noexcept { return long_number_ > 0 || unfinished_ > 0; }
  void note_length_done(const Ok& ok) noexcept;
  double stall_after_s() const noexcept;
  double ask_at() const;
  double ask_end_at() const;
  void end_length(double t);
  void end_unanswered(double t);
  void note_nothing_queued(double t);
  /// A request out of its time has taken lines out of flight whose oks then belong to nothing: only a
  /// question tells that they are done.
  bool stranded() const noexcept {
    return window_.idle() && !outstanding_.empty() && unfinished_ == 0 && !held_;
  }
  void note_missed_ok() noexcept;
  void follow_wire() noexcept;
  void note_gone(Outstanding& line) const noexcept {
    line.gone_t = wire_free_t_;
    line.earliest_gone_t = earliest_free_t_;
  }
  void note_ok_time(const Outstanding& line) noexcept;
  void note_ok(bool temperatures, std::uint64_t lost, double t);

  Window window_;
  Timing timing_;
  double byte_s_;
  const Clock& stamp_;
  FlightRecorder& recorder_;
  std::string output_;
  std::string tail_;  ///< of the last line, what may not go yet
  std::deque<Outstanding> outstanding_;
  std::uint32_t long_number_ = 0;  ///< the last long line, until it is surely done; its ok may be another's
  int oks_past_long_ = 0;
  int words_out_ = 0;  ///< without a number, since the last ok
  bool ok_at_enqueue_ = false;
  std::uint32_t unfinished_ = 0;  ///< the long line that is in the queue or at work, as far as is known
  bool end_due_ = false;
  int ends_asked_ = 0;  ///< behind it
  int ends_unanswered_ = 0;
  double end_asked_t_ = 0;
  double end_heard_t_ = 0;  ///< 0: not yet
  int waits_behind_ = 0;    ///< `wait` since, when all was in the queue
  double round_trip_s_ = 0;
  double wire_free_t_ = 0;      ///< when the last byte written has gone, as estimated
  double earliest_free_t_ = 0;  ///< the same on the fastest wire of that name
  /// An ok came before its line could have gone at the named rate: USB without a wire behind it, or a pty.
  bool wire_is_faster_ = false;
  double pace_ = 1;  ///< of the wire, as a part of the named time for a byte, where it was the brake
  bool wire_is_brake_ = false;     ///< lines were acknowledged lately as fast as such a wire can carry them
  double paced_t_ = 0;             ///< since then that is measured,
  std::uint64_t paced_bytes_ = 0;  ///< and since so many bytes were acknowledged
  double lateness_s_ = 0;          ///< no longer than that this thread awakes late, mostly
  double least_ok_s_ = 0;          ///< the same while the printer did nothing else
  double ok_after_s_ = 0;          ///< so long after its line has gone an ok is here, mostly
  std::uint32_t awaited_ = 0;      ///< the line whose ok the rest is for
  std::uint32_t rested_for_ = 0;
  double awoke_t_ = 0;
  double received_t_ = 0;
  double drain_t_ = 0;  ///< what stands on the wire is waited for since then
  double progress_t_ = 0;
  double patience_t_ = 0;
  double silent_since_t_ = 0;      ///< neither was anything sent nor did an ok come
  double asked_t_ = 0;             ///< a question was last sent
  double ask_after_s_;             ///< of silence; longer where silence turned out to be work
  bool question_due_ = false;      ///< by silence: all that was sent has arrived
  bool doubt_ = false;             ///< what came may have been an ok
  bool asked_in_silence_ = false;  ///< and not yet answered
  int oks_since_ = 0;
  int questions_ = 0;       ///< in this silence
  int questions_open_ = 0;  ///< sent and not answered
  bool packed_once_ = false;
  bool colon_ends_line_ = true;
  bool unpacks_perhaps_ = false;   ///< told not to any more, and has not said so
  std::uint64_t quiet_lines_ = 0;  ///< acknowledged since packing ended
  bool held_ = false;
  bool busy_seen_ = false;
  int waits_ = 0;  ///< `wait` in a row
  std::uint64_t lines_sent_ = 0;
  std::uint64_t bytes_sent_ = 0;
};

}  // namespace voidpath::fw::marlin
