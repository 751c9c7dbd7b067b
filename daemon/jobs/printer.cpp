#include "daemon/jobs/printer.h"

#include <thread>
#include <utility>

namespace voidpath::daemon {
namespace {

/// How often a clock file or port that cannot be opened is tried again, s.
constexpr double kRetry_s = 1.0;

bool ends_print(const fw::Event& event) {
  return fw::ends_print(event.what) || std::holds_alternative<fw::Disconnected>(event.what);
}

std::string wiring_of(const config::PrinterConfig& config) { return config.port + "\n" + config.profile; }

std::string machine_of(const fw::FirmwareInfo& firmware) {
  return firmware.name + "\n" + firmware.machine + "\n" + firmware.uuid;
}

}  // namespace

Printer::Printer(Executor& loop, config::PrinterConfig config, fw::PortOptions options, PortServices services,
                 OnEvent on_event)
    : loop_(loop),
      config_(std::move(config)),
      options_(std::move(options)),
      services_(std::move(services)),
      on_event_(std::move(on_event)) {}

Printer::~Printer() {
  loop_.cancel(retry_);
  close();
}

void Printer::open() {
  loop_.cancel(retry_);
  auto inbox = std::make_shared<Inbox>();
  const auto handler = [this, inbox](const fw::Event& event) {
    bool post = false;
    {
      const std::lock_guard lock(inbox->mutex);
      if (inbox->closed) return;
      inbox->events.push_back(event);
      post = !std::exchange(inbox->posted, true);
    }
    if (!post) return;
    loop_.post([this, inbox] {
      // A closed inbox may outlive its printer: `this` is only touched when it is open.
      std::vector<fw::Event> events;
      {
        const std::lock_guard inner(inbox->mutex);
        inbox->posted = false;
        if (inbox->closed) return;
        events.swap(inbox->events);
      }
      for (const auto& one : events) take(one);
    });
  };
  try {
    const auto clock = services_.open_clock(config_);
    const auto clock_id = identify(config_.clock);
    clock_inode_ = clock_id ? clock_id->inode : 0;
    auto port = services_.open_port(options_, clock, handler);
    inbox_ = std::move(inbox);
    port_ = std::move(port);
    live_ = port_.get();
    offline_reason_ = "not connected yet";
  } catch (const std::exception& error) {
    offline_reason_ = error.what();
    retry_ = loop_.after(kRetry_s, [this] { open(); });
  }
}

void Printer::close() {
  if (inbox_) {
    const std::lock_guard lock(inbox_->mutex);
    inbox_->closed = true;
    inbox_->events.clear();
  }
  live_ = nullptr;
  while (halting_ != 0) std::this_thread::yield();  // they only post
  port_.reset();
  connected_ = false;
  offline_reason_ = "closed";
}

void Printer::take(const fw::Event& event) {
  if (const auto* up = std::get_if<fw::Connected>(&event.what)) {
    connected_ = true;
    offline_reason_.clear();
    if (!up->firmware.name.empty()) memory.firmware = up->firmware.name;
    const std::string machine = machine_of(up->firmware);
    if (machine != machine_) limits_.reset();
    machine_ = machine;
  } else if (const auto* down = std::get_if<fw::Disconnected>(&event.what)) {
    connected_ = false;
    offline_reason_ = down->reason;
    temperatures_.clear();
    watch_clock();
  } else if (const auto* heat = std::get_if<fw::Temperatures>(&event.what)) {
    for (const auto& [sensor, value] : heat->sensors) temperatures_[sensor] = value;
  } else if (const auto* line = std::get_if<fw::LineDone>(&event.what)) {
    position_ = line->file_position;
  } else if (const auto* stats = std::get_if<fw::LinkStats>(&event.what)) {
    link_ = *stats;
  } else if (const auto* told = std::get_if<fw::LimitsKnown>(&event.what)) {
    limits_ = told->limits;
  } else if (std::holds_alternative<fw::Paused>(event.what)) {
    paused_ = true;
  } else if (std::holds_alternative<fw::Resumed>(event.what)) {
    paused_ = false;
  }
  if (timer_) timer_->on(event);
  const bool over = job_ && ends_print(event);
  on_event_(*this, event);
  if (over) {
    job_.reset();
    record.reset();
    timer_.reset();
  }
}

std::optional<KeptLimits> Printer::kept_limits() const {
  if (!limits_) return std::nullopt;
  return KeptLimits{wiring_of(config_), machine_, *limits_};
}

void Printer::recall(const KeptLimits& kept) {
  if (kept.wiring != wiring_of(config_)) return;
  machine_ = kept.machine;
  limits_ = kept.limits;
}

/// A mock that was started again publishes another clock file under the same name.
void Printer::watch_clock() {
  if (config_.clock.empty() || connected_) return;
  loop_.cancel(retry_);
  retry_ = loop_.after(kRetry_s, [this] {
    if (connected_) return;
    const auto now = identify(config_.clock);
    if (now && now->inode != clock_inode_) {
      close();
      open();
    } else {
      watch_clock();
    }
  });
}

void Printer::start(JobId job, const std::filesystem::path& gcode, std::vector<gcode::LayerTime> layers) {
  auto source = services_.open_source(gcode);
  if (!port_) throw std::runtime_error(name() + " is not there: " + offline_reason_);
  size_ = source->size();
  position_ = 0;
  link_ = {};
  timer_.emplace(std::move(layers));
  paused_ = false;
  job_ = job;
  port_->print(std::move(source));
}

void Printer::pause(const std::string& reason) {
  pause_reason_ = reason;
  if (port_) port_->pause();
}

void Printer::resume() {
  if (port_) port_->resume();
}

void Printer::cancel(const std::string& reason) {
  if (port_) port_->cancel(reason);
}

void Printer::command(const std::string& line) {
  if (port_) port_->command(line);
}

void Printer::forget_halt() {
  if (port_) port_->forget_halt();
}

std::vector<std::string> Printer::dialogue() const {
  return port_ ? port_->dialogue() : std::vector<std::string>{};
}

void Printer::halt_now(const std::string& reason) noexcept {
  if (pins_) pins_->cut();
  halt_port(reason);
}

void Printer::halt_port(const std::string& reason) noexcept {
  ++halting_;
  if (fw::PrinterPort* port = live_) port->halt(reason);
  --halting_;
}

void take_times(PrintRecord& record, const PrintTimer& timer) {
  record.measured_s = timer.measured_s();
  record.heating_s = timer.heating_s();
  record.paused_s = timer.paused_s();
  record.total_s = timer.total_s();
  record.resends = timer.resends();
  record.doubts = timer.doubts();
  record.layer_measured_s = timer.layer_s();
}

}  // namespace voidpath::daemon
