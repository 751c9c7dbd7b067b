#pragma once

#include "config/config.h"
#include "daemon/executor.h"
#include "daemon/jobs/job_store.h"
#include "daemon/pins/printer_pins.h"
#include "daemon/timing/print_timer.h"
#include "firmware-io/printer_port.h"

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace voidpath::daemon {

/// How a Printer gets at the world; tests bring their own. Each may throw std::runtime_error.
struct PortServices {
  std::function<std::unique_ptr<fw::PrinterPort>(fw::PortOptions, std::shared_ptr<const fw::Clock>,
                                                 fw::PrinterPort::Handler)>
      open_port;
  std::function<std::unique_ptr<fw::LineSource>(const std::filesystem::path&)> open_source;
  std::function<std::shared_ptr<const fw::Clock>(const config::PrinterConfig&)> open_clock;
};
/// Marlin or S3G over a serial port, G-code files, and the clock the configuration names.
PortServices real_services();

/// A configured printer with what is known of it: connection, temperatures, the print it is at. Loop thread
/// only, but for halt_now().
class Printer {
 public:
  using OnEvent = std::function<void(Printer&, const fw::Event&)>;

  Printer(Executor& loop, config::PrinterConfig config, fw::PortOptions options, PortServices services,
          OnEvent on_event);
  /// Ends a running print safely and closes the port.
  ~Printer();
  Printer(const Printer&) = delete;
  Printer& operator=(const Printer&) = delete;

  const config::PrinterConfig& config() const noexcept { return config_; }
  const std::string& name() const noexcept { return config_.name; }
  /// The MakerBot that the port speaks to; empty: another printer.
  const std::optional<fw::s3g::Machine>& s3g() const noexcept { return options_.s3g; }

  /// Opens the port; where that cannot be, tries again until it can.
  void open();
  /// Destroys the port: a running print is ended by it, heaters off.
  void close();

  bool connected() const noexcept { return connected_; }
  /// A print was handed over and has not ended.
  bool busy() const noexcept { return job_.has_value(); }
  std::optional<JobId> job() const noexcept { return job_; }
  /// The print rests, whether or not the store knows of it.
  bool paused() const noexcept { return paused_; }
  const std::string& offline_reason() const noexcept { return offline_reason_; }
  const std::map<std::string, fw::Temperature>& temperatures() const noexcept { return temperatures_; }
  const PrintTimer* timer() const noexcept { return timer_ ? &*timer_ : nullptr; }
  const fw::LinkStats& link() const noexcept { return link_; }
  /// How the firmware said it is set up, at the last connection in which it did, or as recall() was told;
  /// gone when another machine answers.
  const std::optional<fw::FirmwareLimits>& limits() const noexcept { return limits_; }
  /// These, to be kept for the next run.
  std::optional<KeptLimits> kept_limits() const;
  /// What an earlier run kept; not taken where the configuration has another port or profile since.
  void recall(const KeptLimits& kept);
  std::uint64_t file_position() const noexcept { return position_; }
  std::uint64_t file_size() const noexcept { return size_; }

  /// Streams the file. Throws std::runtime_error when it cannot be opened or the port is not there.
  void start(JobId job, const std::filesystem::path& gcode, std::vector<gcode::LayerTime> layers);
  /// `reason` is told with the pause where the printer gives none.
  void pause(const std::string& reason = {});
  std::string take_pause_reason() { return std::exchange(pause_reason_, {}); }
  void resume();
  void cancel(const std::string& reason);
  void command(const std::string& line);
  /// After an emergency stop: see PrinterPort.
  void forget_halt();
  std::vector<std::string> dialogue() const;
  /// Emergency stop: the power first, then the printer. Any thread, at once; waits on no lock.
  void halt_now(const std::string& reason) noexcept;
  /// The same for whoever has seen to the power.
  void halt_port(const std::string& reason) noexcept;

  /// What is wired to the computer for this printer; null: nothing. Before open().
  void attach(std::unique_ptr<PrinterPins> pins) { pins_ = std::move(pins); }
  PrinterPins* pins() const noexcept { return pins_.get(); }

  /// Kept between runs; whoever changes it saves it.
  PrinterMemory memory;
  /// Where that differs from the profile, in sentences; whoever takes the event fills it.
  std::vector<std::string> limits_differ;
  /// The history record of the running print.
  std::optional<PrintRecord> record;

 private:
  /// Where the session's thread leaves its events until the loop comes for them.
  struct Inbox {
    std::mutex mutex;
    std::vector<fw::Event> events;
    bool posted = false;
    bool closed = false;
  };
  void take(const fw::Event& event);
  void watch_clock();

  Executor& loop_;
  config::PrinterConfig config_;
  fw::PortOptions options_;
  PortServices services_;
  OnEvent on_event_;
  std::shared_ptr<Inbox> inbox_;
  std::unique_ptr<fw::PrinterPort> port_;
  std::atomic<fw::PrinterPort*> live_{nullptr};  ///< port_, for halt_now()
  std::atomic<int> halting_{0};                  ///< how many are in halt_now(): close() waits for them
  std::uint64_t clock_inode_ = 0;
  Executor::TimerId retry_ = 0;

  bool connected_ = false;
  std::string offline_reason_ = "not opened yet";
  std::map<std::string, fw::Temperature> temperatures_;
  std::optional<JobId> job_;
  bool paused_ = false;
  std::optional<PrintTimer> timer_;
  fw::LinkStats link_;
  std::optional<fw::FirmwareLimits> limits_;
  std::string machine_;  ///< whose they are
  std::uint64_t position_ = 0;
  std::uint64_t size_ = 0;
  std::string pause_reason_;
  std::unique_ptr<PrinterPins> pins_;  ///< goes after the port: until then the emergency stop works
};

/// What the timer measured, into the history's record.
void take_times(PrintRecord& record, const PrintTimer& timer);

}  // namespace voidpath::daemon
