#pragma once

#include "config/config.h"
#include "daemon/executor.h"
#include "daemon/jobs/job_store.h"
#include "daemon/timing/print_timer.h"
#include "firmware-io/printer_port.h"

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
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
/// Marlin over a serial port, G-code files, and the clock the configuration names.
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

  /// Opens the port; where that cannot be, tries again until it can.
  void open();
  /// Destroys the port: a running print is ended by it, heaters off.
  void close();

  bool connected() const noexcept { return connected_; }
  /// A print was handed over and has not ended.
  bool busy() const noexcept { return job_.has_value(); }
  std::optional<JobId> job() const noexcept { return job_; }
  const std::string& offline_reason() const noexcept { return offline_reason_; }
  const std::map<std::string, fw::Temperature>& temperatures() const noexcept { return temperatures_; }
  const PrintTimer* timer() const noexcept { return timer_ ? &*timer_ : nullptr; }
  const fw::LinkStats& link() const noexcept { return link_; }
  std::uint64_t file_position() const noexcept { return position_; }
  std::uint64_t file_size() const noexcept { return size_; }

  /// Streams the file. Throws std::runtime_error when it cannot be opened or the port is not there.
  void start(JobId job, const std::filesystem::path& gcode, std::vector<gcode::LayerTime> layers);
  void pause();
  void resume();
  void cancel(const std::string& reason);
  void command(const std::string& line);
  std::vector<std::string> dialogue() const;
  /// Emergency stop. Any thread, at once.
  void halt_now(const std::string& reason) noexcept;

  /// Kept between runs; whoever changes it saves it.
  PrinterMemory memory;
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
  std::mutex port_mutex_;  ///< guards port_ against halt_now(): held while port_ changes, and by halt_now()
  std::uint64_t clock_inode_ = 0;
  Executor::TimerId retry_ = 0;

  bool connected_ = false;
  std::string offline_reason_ = "not opened yet";
  std::map<std::string, fw::Temperature> temperatures_;
  std::optional<JobId> job_;
  std::optional<PrintTimer> timer_;
  fw::LinkStats link_;
  std::uint64_t position_ = 0;
  std::uint64_t size_ = 0;
};

/// What the timer measured, into the history's record.
void take_times(PrintRecord& record, const PrintTimer& timer);

}  // namespace voidpath::daemon
