#pragma once

#include "firmware-io/clock.h"
#include "firmware-io/dialogue.h"
#include "firmware-io/flight_recorder.h"
#include "firmware-io/marlin/codec.h"
#include "firmware-io/marlin/link.h"
#include "firmware-io/marlin/print_job.h"
#include "firmware-io/marlin/settings.h"
#include "firmware-io/marlin/words.h"

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
  double packing_s = 0.5;       ///< for MeatPack's answer
  double nameless_s = 1;        ///< M115 gave an ok and no name: some firmware says the name late, or never
};

struct DriverOptions {
  WindowOptions window;
  Timing timing;
  HandshakeTiming handshake;
  double byte_s = 10.0 / 115200;  ///< wire time of one byte
  std::vector<std::string> cancel_gcode;
  bool meatpack = true;  ///< used when the firmware offers it
  int keepalive_s = 2;   ///< a Marlin at a long command is to say so this often; 0: as it is set
};

/// The Marlin side of a session: handshake, dialogue, print. See Dialogue.
class Driver final : public Dialogue {
 public:
  Driver(DriverOptions options, const Clock& stamp, FlightRecorder& recorder,
         std::function<void(const Event&)> handler);

  void opened(double t) override;
  void received(std::string_view bytes, double t) override;
  void elapsed(double t) override;
  double deadline() const noexcept override;
  void lost(const std::string& reason) override;

  void print(std::unique_ptr<LineSource> source, double t) override;
  void pause() override;
  void resume(double t) override;
  void cancel(const std::string& reason, double t) override;
  void halt(const std::string& reason, double t) override;
  bool halt_heard() const noexcept override { return halt_heard_; }
  void command(const std::string& text, double t) override;
  void shut_down(double t) override;
  bool cold() const noexcept override { return finished() || (job_ && job_->cold()); }
  bool finished() const noexcept override { return phase_ == Phase::closed || (!job_ && !still_halting()); }

  std::string& output() noexcept override { return link_.output(); }
  bool take_urgent() noexcept override { return std::exchange(urgent_, false); }
  double unhurried_until() const noexcept override { return rest_until_; }
  void rested(double until, double t) noexcept override { link_.note_rested(until, t); }
  bool closing() const noexcept override { return phase_ == Phase::closed; }

 private:
  enum class Phase { closed, booting, greeting, settling, identifying, packing, ready, halted };

  void emit(decltype(Event::what) what);
  void enter(Phase phase, double deadline) { phase_ = phase, phase_deadline_ = deadline; }
  void greet(double t);
  void become_ready(double t);
  bool offers(const std::string& capability) const;
  void ask_packing(double t);
  bool packing_again(double t);
  void packing_answered(const PackState& state);
  void packing_unanswered();
  void dispatch(const std::string& line, double t);
  void dispatch_handshake(const Reply& reply, double t);
  void dispatch_ready(const Reply& reply, double t);
  void on_action(const Action& action, double t);
  void on_prompt(const Action& action);
  void on_echo(const std::string& text);
  bool was_sent(std::string_view refused) const;
  void on_error(const Error& error, double t);
  void on_restart(double t);
  void waits_no_more(double t);
  void go_on(double t);
  void leave_panel(double t);
  bool may_leave_panel() const;
  std::vector<std::string> last_lines(std::vector<std::string> lines);
  void handshake_elapsed(double t);
  void settle(double t);
  void collect(double t);
  void drop_finished_job();
  void forget_dialogue();
  void ask_firmware();
  void tell_limits();
  void pump(double t);
  void check_health(double t);
  void poll_temperature(double t);
  bool reports_by_itself() const noexcept;
  double poll_at() const noexcept;
  double end_probe_at() const noexcept;
  void command_line(std::string_view raw, double t);
  void say_halt(double t);
  bool still_halting() const noexcept { return phase_ == Phase::halted && phase_deadline_ <= halting_until_; }
  void give_up(const std::string& reason, double t);
  void disconnect(const std::string& reason);
  LinkStats link_stats() const;
  void report_stats();
  void note_sensors(const Sensors& sensors);
  void note_heaters(const Sensors& sensors);

  DriverOptions options_;
  HeldClock stamp_;  ///< looked at by whatever is called from outside
  FlightRecorder& recorder_;
  std::function<void(const Event&)> handler_;
  Link link_;
  LineSplitter splitter_;
  std::unique_ptr<PrintJob> job_;
  int queries_unanswered_ = 0;  ///< of those that follow a connection
  SettingsReader settings_;
  std::deque<std::string> queries_;   ///< of our own, once after connecting
  std::deque<std::string> controls_;  ///< lines of our own and the user's, ahead of the file's
  FirmwareInfo firmware_;
  bool autoreport_ = false;  ///< it tells its temperatures by itself
  Phase phase_ = Phase::closed;
  double phase_deadline_ = 0;
  bool halt_heard_ = false;
  double halting_until_ = 0;  ///< phase halted: M112 is repeated until then, or until it was heard
  bool start_seen_ = false;
  int greetings_ = 0;
  int packing_asked_ = 0;
  double repacking_until_ = 0;  ///< 0: not asked
  double rest_until_ = 0;
  bool end_probed_ = false;
  bool packed_once_ = false;  ///< the firmware may still unpack
  double asked_t_ = 0;        ///< the handshake's last question
  bool name_told_ = false;    ///< to the link: what follows, up to the next ok, belongs to it
  bool connected_ = false;
  std::string last_loss_;
  bool urgent_ = false;
  bool hot_ = false;
  double received_t_ = 0;
  double polled_t_ = 0;
  double stats_t_ = 0;
  LinkStats before_print_;  ///< the link's counters when the print began
  std::uint64_t doubtful_seen_ = 0;
  std::uint64_t nameless_seen_ = 0;
  std::uint64_t odd_commands_ = 0;   ///< never sent, or beyond reason: damage that no checksum showed
  bool printer_waits_ = false;       ///< it said so; paused until its next ok
  int panel_words_ = 0;              ///< M108s since the last ok
  bool panel_waits_ = false;         ///< it waits for a person, whoever paused the print
  const Parking* parked_ = nullptr;  ///< it has left the print's place, and reads on
  bool unparking_ = false;           ///< it was told to go back
  std::string prompt_;               ///< a question as far as it was heard
  int prompt_choices_ = 0;
};

}  // namespace voidpath::fw::marlin
