#pragma once

#include "tests/mock_printer/command.h"
#include "tests/mock_printer/firmware.h"
#include "tests/mock_printer/heating.h"
#include "tests/mock_printer/line_protocol.h"
#include "tests/mock_printer/motion.h"
#include "tests/mock_printer/options.h"
#include "tests/mock_printer/rx_ring.h"
#include "tests/mock_printer/unpacker.h"
#include "tests/mock_printer/wire.h"

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// A Marlin-class firmware in memory: bytes in, bytes out, on a clock of its own that moves only when told.
/// Deterministic; no threads, no files, no waiting. A discrete-event machine: `feed` what the host sends,
/// `advance_to` a time, `take_output` what the host can read by then.
namespace voidpath::test::mock {

struct Statistics {
  std::uint64_t commands = 0;       ///< executed
  std::uint64_t lines = 0;          ///< read, good or bad
  std::uint64_t resends = 0;        ///< asked for
  std::uint64_t bytes_dropped = 0;  ///< lost to a full receive buffer or a booting printer
  std::uint64_t faults = 0;         ///< injected
  std::uint64_t unknown = 0;        ///< commands answered as unknown
  std::uint64_t resets = 0;
  double motion_s = 0;  ///< time in which planned moves were executed (homing is no planned move)
  double span_s = 0;    ///< from the first of these to the end of the last
  double homing_s = 0, dwell_s = 0, heating_s = 0;
  double clock_s = 0;
  std::uint64_t blocks = 0;
  double hotend_target = 0, bed_target = 0, hotend = 0, bed = 0, fan = 0;
  bool halted = false;
};

class MockMarlin final : public Firmware {
 public:
  explicit MockMarlin(const Options& options = {});

  /// The host writes bytes now.
  void feed(std::string_view bytes) override;
  /// Lets the clock run to `time` (s, never backwards) and does all that is due until then.
  void advance_to(double time) override;
  double now() const override { return now_; }
  /// When something happens without the host doing anything; infinity when nothing will.
  double next_event() const override;
  /// What has reached the host by now.
  std::string take_output() override;

  /// True while the printer has answered everything it got and could use more: the moment at which an
  /// accelerated clock must stand still for the host. (With a full planner more input would change nothing.)
  bool waits_for_host() const override;
  /// Grows with each command that carries the print on; polls (M105, M114, ...) do not count.
  std::uint64_t progress() const override { return progress_; }
  /// Each command as it begins to execute.
  void on_command(std::function<void(std::string_view)> callback) override { log_ = std::move(callback); }
  /// Each line as it is taken from the wire, with its number if it had one.
  void on_accepted(std::function<void(std::string_view, std::optional<std::int64_t>)> callback) {
    accepted_ = std::move(callback);
  }
  /// Power-on or reset: state lost, heaters off, `start` again.
  void reset() override;
  /// A person presses the button at the panel: what waits for one goes on.
  void press_button() {
    user_wait_ = false;
    process();
  }
  /// Seconds for which the cable is to be out, once after such a fault fired.
  std::optional<double> take_unplug() override;

  Statistics statistics() const override;
  bool drained() const override { return motion_.drained(); }
  const Motion& motion() const { return motion_; }
  const Heater& hotend() const { return hotend_.heater(); }
  const Heater& bed() const { return bed_.heater(); }
  bool halted() const { return halted_; }

 private:
  struct Queued {
    std::string text;
    std::optional<std::int64_t> number;
    bool own = false;  ///< the printer's own idea: neither logged nor acknowledged
  };
  /// What the executing command still has to do, in order.
  struct Task {
    enum class Kind { kMove, kDrained, kDwell, kHeat, kUser, kCall };
    Kind kind;
    Axes target{};                   ///< kMove, mm
    double seconds = 0;              ///< kDwell
    std::optional<HeatWait> heat{};  ///< kHeat
    std::function<void()> action{};  ///< kCall
    double* account = nullptr;       ///< kDwell: statistics the time is booked to
  };

  // mock_marlin.cpp: the loop; mock_replies.cpp: what it says
  void boot();
  void process();
  void fire_due();
  void receive(char byte);
  void read_lines();
  void read_character(char byte);
  void handle_line_end(char byte);
  void handle_result(const LineResult& result);
  void emergency(std::string_view line);
  void emergency_at(char byte);
  void answer_halted(std::string_view line);
  void refuse_command(std::string_view why);
  void quick_stop();
  void refuse(const RefusedLine& refused);
  void ask_for(std::int64_t number);
  bool misses_line() const;
  void begin_command();
  bool resume();
  bool task_done(Task& task);
  void finish_command();
  void send_ok(std::string_view tail);
  void write(std::string_view text);
  void write_line(std::string_view text);
  void apply(const Fault& fault);
  void kill(std::string_view reason, std::string_view heater);
  void tell_halt();
  void halt_with(std::string_view first_line);
  void tick_second();
  std::string temperatures() const;
  std::string free_slots() const;

  // mock_commands.cpp, mock_moves.cpp: what commands do
  void execute(const Command& command);
  bool execute_motion(const Command& command);
  bool execute_heat(const Command& command);
  bool execute_settings(const Command& command);
  bool execute_host(const Command& command);
  bool execute_macro(const Command& command);
  void move(const Command& command);
  void arc(const Command& command, bool clockwise);
  void home(const Command& command);
  void set_position(const Command& command);
  void wait_heat(const Command& command, bool bed);
  void tune();
  void pause_for_user(std::string_view action);
  void report_position();
  void report_settings();
  void report_old_settings();
  void report_volume();
  Axes target_of(const Command& command);
  void queue_move(Axes target);
  void after_drain(std::function<void()> action);
  double feed_mm_s() const { return feed_ * feed_factor_; }

  Options options_;
  double now_ = 0;
  Wire wire_in_, wire_out_;
  std::string ready_out_;
  RxRing ring_;
  Unpacker unpacker_;
  LineProtocol protocol_;
  FaultInjector faults_;
  std::deque<Queued> queue_;  ///< the executing command stays in front until it is done
  Motion motion_;
  GuardedHeater hotend_, bed_;
  std::function<void(std::string_view)> log_;
  std::function<void(std::string_view, std::optional<std::int64_t>)> accepted_;

  bool executing_ = false;
  std::string ok_tail_;  ///< what follows that ok
  std::vector<Task> tasks_;
  std::size_t task_ = 0;
  double task_until_ = -1;  ///< of the current dwell, or the next look of a heat wait
  double next_busy_ = 0, next_second_ = 0, next_report_ = 0, next_wait_ = 0;
  double report_interval_ = 0;  ///< M155; 0: off
  double busy_interval_ = 2;
  double boot_until_ = 0, silent_until_ = -1;
  double last_byte_t_ = 0;
  double slow_s_ = 0;
  std::uint64_t slow_commands_ = 0;
  bool halted_ = false;
  bool homed_ = false;
  std::string halt_reason_;  ///< as it was said first
  bool user_wait_ = false, heat_wait_ = false;
  bool parked_ = false;  ///< Klipper's PAUSE or Prusa's M601, which go on reading
  bool tuning_ = false;  ///< M303: says neither that it is busy nor what M155 asked for
  std::optional<double> unplug_;
  std::string emergency_line_;

  Axes position_{};  ///< mm, logical
  bool relative_ = false, relative_e_ = false;
  double feed_ = 25, feed_factor_ = 1, flow_ = 1;  ///< mm/s and ratios
  bool cold_allowed_ = false;
  double fan_ = 0;
  double segment_feed_ = 0;

  std::uint64_t progress_ = 0;
  Statistics totals_;
};

/// Number as the firmware prints it, with so many decimals.
std::string fixed(double value, int decimals);

}  // namespace voidpath::test::mock
