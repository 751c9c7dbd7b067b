#pragma once

#include "firmware-io/clock.h"
#include "firmware-io/flight_recorder.h"
#include "firmware-io/s3g/account.h"
#include "firmware-io/s3g/action.h"
#include "firmware-io/s3g/packet.h"
#include "firmware-io/s3g/question.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace voidpath::fw::s3g {

/// Protocol times in seconds of the steady clock, which is handed in as `t`.
struct LinkTiming {
  /// For a reply. The firmware gives up on a damaged packet after 0.2 s and says so.
  double reply_s = 0.35;
  /// After a damaged exchange, before the next packet: what is still on the wire has come by then.
  double quiet_s = 0.03;
  double silence_s = 10;       ///< without any good reply: nobody is there
  double drain_poll_s = 0.05;  ///< between asks whether all is done
  double insist_s = 2;         ///< so long an abort is said again
  /// Of one byte on the wire; 0: not known. A reply cannot come before the packet and itself have crossed it.
  double byte_s = 0;
};

/// What became of a request.
struct Answer {
  std::string query;  ///< its payload
  std::string data;   ///< behind the reply code
  ReplyCode code = ReplyCode::ok;
};
struct Accepted {
  Action action;
  bool in_doubt = false;  ///< it may have been run twice
};
/// The queue has no room; it is not in it.
struct NoRoom {
  Action action;
};
/// The firmware will not take it; code is unsupported, cancelled, busy or heater_failure.
struct Refused {
  Action action;
  ReplyCode code = ReplyCode::unsupported;
};
/// Silence, or the same packet damaged again and again.
struct Dead {
  std::string reason;
};
using Outcome = std::variant<Answer, Accepted, NoRoom, Refused, Dead>;

/// One packet outstanding, its reply awaited; what was damaged or lost is found out about and put right. No
/// I/O. One thread.
///
/// A command is sent again only when the firmware is known not to have queued it: an undamaged reply says so,
/// or what the queue holds (Account), or, once all is done, where the motors stand. Before that a query with
/// its own kind of reply goes both ways, so that no late reply is taken for another's. Nor is a doubled one,
/// if its copy comes sooner than the wire allows; one that comes later cannot be told from what it copies.
class Link {
 public:
  Link(LinkTiming timing, const Clock& stamp, FlightRecorder& recorder)
      : timing_(timing), stamp_(stamp), recorder_(recorder) {}

  void restart(double t);

  bool idle() const noexcept { return step_ == Step::idle; }
  /// A command's fate will show when all is done, which may take long: queries go out meanwhile.
  bool draining() const noexcept { return step_ == Step::drain_wait; }
  /// Only when draining: that command is forgotten, whatever became of it.
  void give_up();
  /// Only when idle or draining.
  void ask(Question question, double t);
  /// Not sent again when its reply is lost: for what is no question. Then the code is generic_error.
  void ask_once(std::string payload, double t);
  void act(Action action, double t);
  /// Sends at once, whatever is under way, which is forgotten; and again after each silence until the
  /// firmware has answered it with ok, or with heater_failure, after which it answers nothing else.
  void insist(std::string payload, double t);

  void received(std::string_view bytes, double t);
  void elapsed(double t);
  double deadline() const noexcept;
  /// What the last request came to, once.
  std::optional<Outcome> take();

  std::string& output() noexcept { return output_; }
  Account& account() noexcept { return account_; }
  std::uint64_t packets_sent() const noexcept { return packets_sent_; }
  std::uint64_t bytes_sent() const noexcept { return bytes_sent_; }
  std::uint64_t resends() const noexcept { return resends_; }

 private:
  enum class Step {
    idle,
    asking,      ///< for the caller's query, or one of our own: see why_
    acting,      ///< a command is out
    quiet,       ///< nothing is sent until the line has been quiet
    drain_wait,  ///< until asking again whether all is done
    insisting
  };
  enum class Why { caller, cancel, line_before, free, line_after, finished, position };

  void send(std::string_view payload, double t);
  void send_query(Query query, Why why, double t);
  void begin_action(double t);
  void send_action(double t);
  void on_packet(const Packet& packet, double t);
  bool is_copy(const Packet& packet, double t);
  bool notes_cancel(const std::string& data);
  void on_query_reply(const std::string& payload, double t);
  void on_action_reply(ReplyCode code, double t);
  void on_insisted(const Packet& packet, double t);
  void say_again(double t);
  void on_inner_answer(const std::string& data, double t);
  void lost_reply();
  void disturbed(double t);
  void go_on(double t);
  void judge(const Glance& glance, double t);
  void judge_position(const std::string& data, double t);
  void drain(double t) { send_query(Query::finished, Why::finished, t); }
  void settle(bool was_taken, double t);
  void done(Outcome outcome);

  LinkTiming timing_;
  const Clock& stamp_;
  FlightRecorder& recorder_;
  PacketReader reader_;
  Account account_;
  std::string output_;
  std::optional<Outcome> outcome_;

  Step step_ = Step::idle;
  Why why_ = Why::caller;
  Question query_;  ///< under way
  std::optional<Action> action_;
  bool aside_ = false;  ///< the caller's query goes between two of the drain's own
  double drain_t_ = 0;
  bool once_ = false;  ///< the caller's query must not be sent again
  bool in_doubt_ = false;
  bool owed_ = false;       ///< a reply to what was under way when it became urgent
  bool running_ = false;    ///< a build, when last asked
  bool unsure_ = false;     ///< a reply that was lost may have told that the build was cancelled
  bool times_tell_ = true;  ///< the wire is as slow as it was said to be
  std::string position_;    ///< answered last, where it fitted nothing
  int failures_ = 0;        ///< of the request under way, in a row
  int glances_ = 0;
  Glance glance_;
  double due_t_ = 0, sent_t_ = 0;
  double patient_until_ = 0;      ///< quiet is waited for, or an abort said again
  std::size_t packet_bytes_ = 0;  ///< of the one sent last
  std::size_t last_bytes_ = 0;    ///< of the good reply before
  double good_t_ = 0;             ///< when the last undamaged reply came
  std::uint64_t packets_sent_ = 0, bytes_sent_ = 0, resends_ = 0;
};

/// Bytes in hexadecimal, for the record of the dialogue: "9B 00 01".
std::string hex(std::string_view bytes);

}  // namespace voidpath::fw::s3g
