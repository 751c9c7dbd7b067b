#pragma once

#include "tests/mock_printer/firmware.h"
#include "tests/mock_printer/heating.h"
#include "tests/mock_printer/mock_marlin.h"
#include "tests/mock_printer/motion.h"
#include "tests/mock_printer/s3g_options.h"
#include "tests/mock_printer/wire.h"

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace voidpath::test::mock {

/// A MakerBot-class firmware in memory: S3G packets in, replies out. Strict: whatever such a machine must
/// never be sent (a command of the wrong length, homing against the frame, more than an axis can do, a tool
/// that is not there) is kept as a violation.
class MockS3g final : public Firmware {
 public:
  explicit MockS3g(const S3gOptions& options = {});

  void feed(std::string_view bytes) override;
  void advance_to(double time) override;
  double now() const override { return now_; }
  double next_event() const override;
  std::string take_output() override;
  bool waits_for_host() const override;
  bool drained() const override { return motion_.drained() && mode_ == Mode::ready; }
  std::uint64_t progress() const override { return executed_; }
  void on_command(std::function<void(std::string_view)> callback) override { log_ = std::move(callback); }
  void reset() override;
  std::optional<double> take_unplug() override;
  Statistics statistics() const override;

  /// Payload of each command as it leaves the queue.
  void on_payload(std::function<void(const std::string&)> callback) { payloads_ = std::move(callback); }
  const std::vector<std::string>& violations() const { return violations_; }
  /// The button at the panel.
  void press_pause();
  void cancel_at_panel();
  /// As its guards do when a heater or a sensor fails: told like a cancel first, and then instead of any
  /// reply.
  void shut_heaters_down();
  /// Chosen at the panel; moves for so long, and refuses all actions meanwhile.
  void print_from_card(double seconds);
  bool prints_from_card() const { return card_; }
  bool paused() const { return paused_; }
  std::uint64_t aborts() const { return aborts_; }
  std::size_t queued_bytes() const { return queue_bytes_; }
  const Heater& hotend(std::size_t tool = 0) const { return hotends_[tool].heater(); }
  /// Steps X Y Z A B at the end of all that was executed.
  const std::array<std::int32_t, 5>& position() const { return position_; }

 private:
  enum class Mode { ready, timed, wait_tool, wait_bed };
  enum class Reading { start, length, payload, crc, done };

  // mock_s3g.cpp: the wire, packets and queries
  void fire_due();
  void end_cancel();
  void receive(char byte);
  void packet_byte(char byte);
  void refuse_packet(unsigned code);
  void forget_packet();
  void look_at_packet();
  bool is_reading() const { return packet_state_ != Reading::start && packet_state_ != Reading::done; }
  void handle_packet(const std::string& payload);
  void answer_query(const std::string& payload);
  std::string tool_answer(const std::string& payload) const;
  void take_action(const std::string& payload);
  void reply(std::string_view payload);
  void reply_code(unsigned code) { reply(std::string(1, static_cast<char>(0x80U | code))); }
  void apply(const Fault& fault);
  void stop_all();
  void tick_second();
  void toggle_pause();

  // s3g_commands.cpp: what leaves the queue
  void run_queue();
  void run_card();
  void begin(const std::string& payload);
  bool needs_rest(unsigned code) const;
  void move(const std::string& payload);
  void raw_move(const std::string& payload);
  void tool_action(const std::string& payload);
  void home(const std::string& payload);
  void timed(double seconds, double& account);
  void say(const std::string& line);
  void violate(const std::string& what);
  Axes position_mm() const;
  bool has_right_length(const std::string& payload);

  S3gOptions options_;
  double now_ = 0;
  Wire wire_in_, wire_out_;
  std::string ready_out_;
  FaultInjector faults_;
  Motion motion_;
  std::vector<GuardedHeater> hotends_;
  GuardedHeater bed_;
  std::function<void(std::string_view)> log_;
  std::function<void(const std::string&)> payloads_;

  // the packet being read
  Reading packet_state_ = Reading::start;
  std::size_t packet_length_ = 0;
  std::string packet_;
  double packet_begun_ = -1;
  std::optional<unsigned> packet_error_;  ///< code of a refusal that is due
  double sending_until_ = -1;

  std::deque<std::string> queue_;
  std::size_t queue_bytes_ = 0;
  Mode mode_ = Mode::ready;
  double until_ = -1;
  int waiting_tool_ = 0;
  unsigned tool_ = 0;  ///< whose offset moves are made with; outlives a print
  std::array<std::int32_t, 5> position_{};
  std::uint32_t line_ = 0;
  unsigned build_ = 0;
  bool paused_ = false, cancel_note_ = false, heat_shutdown_ = false, card_ = false;
  double boot_until_ = 0, silent_until_ = -1, busy_until_ = -1, resume_at_ = -1, next_second_ = 1;
  double cancelled_at_ = -1;  ///< by when the head has left the part
  double slow_s_ = 0;
  std::uint64_t slow_commands_ = 0;
  std::optional<double> unplug_;
  std::uint64_t executed_ = 0, aborts_ = 0;
  double fan_ = 0;
  std::vector<std::string> violations_;
  Statistics totals_;
};

}  // namespace voidpath::test::mock
