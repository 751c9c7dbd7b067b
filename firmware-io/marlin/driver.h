#pragma once

#include "firmware-io/flight_recorder.h"
#include "firmware-io/marlin/codec.h"
#include "firmware-io/marlin/link.h"
#include "firmware-io/marlin/print_job.h"

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace voidpath::fw::marlin {

/// Seconds of the steady clock.
struct HandshakeTiming {
  double boot_wait_s = 3;       ///< for `start` after opening
  double banner_quiet_s = 0.3;  ///< the boot's chatter is over
  double answer_s = 2;          ///< for an ok to M110
  double settle_s = 0.1;        ///< for stray answers behind it
  double identify_s = 10;       ///< for M115
  double nameless_s = 1;        ///< M115 gave an ok and no name: some firmware says the name late, or never
};

struct DriverOptions {
  WindowOptions window;
  Timing timing;
  HandshakeTiming handshake;
  double byte_s = 10.0 / 115200;  ///< wire time of one byte
  std::vector<std::string> cancel_gcode;
};

/// Everything between the bytes and the events: handshake, dialogue, print. No thread, no I/O, no clock but
/// the event stamps; `t` is the steady clock's time. One thread.
///
/// opened() begins; received(), elapsed() (at deadline() at the latest) and the commands drive it; output()
/// is to be written after each call; once closing() holds, the port must be closed and may be opened again.
class Driver {
 public:
  Driver(DriverOptions options, const Clock& stamp, FlightRecorder& recorder,
         std::function<void(const Event&)> handler);

  void opened(double t);
  void received(std::string_view bytes, double t);
  void elapsed(double t);
  double deadline() const noexcept;
  /// The port is gone, or could not be opened. Reported once for each reason.
  void lost(const std::string& reason);

  void print(std::unique_ptr<LineSource> source, double t);
  void pause();
  void resume(double t);
  void cancel(const std::string& reason, double t);
  void halt(const std::string& reason, double t);
  void command(const std::string& line, double t);
  /// Ends a print with the heaters first. Afterwards finished() tells when that is through.
  void shut_down(double t);
  bool finished() const noexcept { return phase_ == Phase::closed || !job_; }

  std::string& output() noexcept { return link_.output(); }
  /// True once after halt(): what was written before and is still on its way should be thrown away.
  bool take_urgent() noexcept { return std::exchange(urgent_, false); }
  bool closing() const noexcept { return phase_ == Phase::closed; }

 private:
  enum class Phase { closed, booting, greeting, settling, identifying, ready, halted };

  void emit(decltype(Event::what) what);
  void enter(Phase phase, double deadline) { phase_ = phase, phase_deadline_ = deadline; }
  void greet(double t);
  void become_ready(double t);
  void dispatch(const std::string& line, double t);
  void dispatch_handshake(const Reply& reply, double t);
  void dispatch_ready(const Reply& reply, double t);
  void on_action(const Action& action, double t);
  void on_error(const Error& error, double t);
  void on_restart(double t);
  void handshake_elapsed(double t);
  void settle(double t);
  void collect(double t);
  void drop_finished_job();
  void pump(double t);
  void check_health();
  void poll_temperature(double t);
  bool reports_by_itself() const noexcept;
  double poll_at() const noexcept;
  void fail(const std::string& reason);
  void disconnect(const std::string& reason);
  LinkStats link_stats() const;
  void report_stats();
  void note_sensors(const Sensors& sensors);

  DriverOptions options_;
  const Clock& stamp_;
  FlightRecorder& recorder_;
  std::function<void(const Event&)> handler_;
  Link link_;
  LineSplitter splitter_;
  std::unique_ptr<PrintJob> job_;
  std::deque<std::string> controls_;  ///< lines of our own and the user's, ahead of the file's
  FirmwareInfo firmware_;
  Phase phase_ = Phase::closed;
  double phase_deadline_ = 0;
  bool start_seen_ = false;
  int greetings_ = 0;
  double greeted_t_ = 0;
  bool connected_ = false;
  std::string last_loss_;
  bool urgent_ = false;
  bool hot_ = false;
  double received_t_ = 0;
  double polled_t_ = 0;
  double stats_t_ = 0;
  LinkStats before_print_;  ///< the link's counters when the print began
  std::uint64_t doubtful_seen_ = 0;
};

}  // namespace voidpath::fw::marlin
