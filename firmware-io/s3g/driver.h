#pragma once

#include "firmware-io/dialogue.h"
#include "firmware-io/event.h"
#include "firmware-io/flight_recorder.h"
#include "firmware-io/s3g/print_job.h"

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace voidpath::fw::s3g {

struct DriverOptions {
  Machine machine;
  LinkTiming timing;
  double boot_wait_s = 3;  ///< so long a printer may boot after opening, before silence counts
  std::vector<std::string> cancel_gcode;
};

inline constexpr char kHeatersShut[] =
    "the printer has shut its heaters down: a heater or its sensor has failed";

/// The S3G side of a session: who is there, what it says of itself, and a print. See Dialogue.
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
  bool finished() const noexcept override {
    return phase_ == Phase::closed || (!job_ && phase_ != Phase::halted);
  }

  std::string& output() noexcept override { return link_.output(); }
  bool take_urgent() noexcept override { return false; }  // one packet at the most, which must be whole
  bool closing() const noexcept override { return phase_ == Phase::closed; }

 private:
  enum class Phase {
    closed,
    greeting,
    identifying,
    ready,
    aborting,  ///< until the firmware has heard it; then it is greeted anew
    halted     ///< the same, and then closed
  };

  void emit(decltype(Event::what) what);
  void greeting_since(double t);
  void greet(double t);
  void become_ready(double t);
  void take_outcomes(double t);
  void on_answer(const Answer& answer, double t);
  void on_identity(const Answer& answer, double t);
  void on_status(const Answer& answer, double t);
  void on_tool_answer(const Answer& answer);
  void on_build(const Answer& answer, double t);
  void on_cancelled(const Answer& answer);
  void on_refused(const Refused& refused);
  void on_dead(const Dead& dead, double t);
  void on_aborted(ReplyCode code, double t);
  void check_panel(double t);
  void pump(double t);
  bool pump_ready(double t);
  bool pump_query(double t);
  void pump_aside(double t);
  bool pump_action(double t);
  void command_line(std::string_view line, double t);
  void want_paused(bool paused);
  double toggle_t() const noexcept;
  void act(Action action, double t);
  void hold(Action action, double t);
  void on_room(const Answer& answer, double t);
  void forget_sending();
  void schedule_polls(double t);
  void end_job(std::vector<std::string> lines, decltype(Event::what) outcome, double t);
  void abort_job(decltype(Event::what) outcome, double t);
  void drop_job(decltype(Event::what) outcome);
  void disconnect(const std::string& reason);
  void settle(double t);
  std::vector<std::string> leaving() const;
  LinkStats link_stats() const;
  void report_stats();

  DriverOptions options_;
  const Clock& stamp_;
  std::function<void(const Event&)> handler_;
  Link link_;
  Encoder encoder_;
  std::unique_ptr<PrintJob> job_;
  std::deque<Action> controls_;        ///< the user's, ahead of the file's
  std::deque<Question> polls_;         ///< due
  bool polled_last_ = false;           ///< polls and actions take turns
  bool asked_by_job_ = false;          ///< the question under way
  bool act_by_job_ = false;            ///< the action under way, or held
  std::optional<Action> held_;         ///< waits for room in the queue
  bool asked_room_ = false;            ///< the question under way is whether there is room
  std::optional<std::uint32_t> room_;  ///< bytes free at least; empty: plenty, as far as known
  double room_t_ = 0;                  ///< when to ask again
  int room_asks_ = 0;

  Phase phase_ = Phase::closed;
  double phase_deadline_ = 0;
  double greeting_until_ = 0;
  double last_t_ = 0;
  FirmwareInfo firmware_;
  std::map<std::string, Temperature> sensors_;
  std::string last_loss_;
  bool connected_ = false;
  bool halt_heard_ = false;
  bool told_cancelled_ = false;  ///< by the printer, which says so as well before it owns up to dead heaters
  double poll_t_ = 0, build_t_ = 0, stats_t_ = 0, glance_t_ = 0;
  double progress_t_ = 0;  ///< when a command was accepted or begun, or might not be

  bool wants_paused_ = false;  ///< the printer should stand still
  bool toggle_pending_ = false;
  bool build_known_ = false;  ///< asked since that was wanted
  double toggled_t_ = -1e9;
  BuildState build_ = BuildState::none;
  std::uint32_t build_line_ = 0, progress_line_ = 0;
  bool seen_running_ = false;  ///< the firmware has known of this print
  int glance_step_ = 0;        ///< of the three queries that make a Glance
  Glance glance_;
  LinkStats before_print_;
  std::uint64_t doubts_ = 0;  ///< commands that may have run twice
};

}  // namespace voidpath::fw::s3g
