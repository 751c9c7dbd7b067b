#include "tests/mock_printer/runner.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

namespace voidpath::test::mock {
namespace {

double wall_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Longest wait of one turn, s: signals and clocks want a look now and then.
constexpr double kTurn = 0.05;

void write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(fd, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return;
    text.remove_prefix(static_cast<std::size_t>(n));
  }
}

}  // namespace

Runner::Runner(const Options& printer, const RunnerOptions& options)
    : Runner(std::make_unique<MockMarlin>(printer), options) {}

Runner::Runner(std::unique_ptr<Firmware> printer, const RunnerOptions& options)
    : options_(options),
      printer_(std::move(printer)),
      pty_(options.link),
      pacer_(options.speed, options.grace_s) {
  if (!options.clock_file.empty()) clock_ = std::make_unique<ClockFile>(options.clock_file);
  if (options.log_file.empty()) return;
  log_ = ::open(options.log_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (log_ < 0) throw std::system_error(errno, std::generic_category(), options.log_file);
  printer_->on_command([this](std::string_view command) { write_all(log_, std::string(command) + '\n'); });
}

Runner::~Runner() {
  if (log_ >= 0) ::close(log_);
}

void Runner::run(RunnerRequests& requests) {
  while (!requests.stop) {
    if (requests.report.exchange(false)) write_all(STDERR_FILENO, to_json(printer_->statistics()) + '\n');
    if (requests.reset.exchange(false)) printer_->reset();
    turn(wall_now());
  }
}

void Runner::turn(double wall) {
  if (plug_at_ && wall >= *plug_at_) {
    pty_.plug();
    plug_at_.reset();
    if (options_.reset_on_open) printer_->reset();
  }
  let_time_pass(wall);
  if (clock_) clock_->publish(printer_->now());
  exchange();
  if (const auto seconds = printer_->take_unplug()) {
    pty_.unplug();
    out_.clear();
    plug_at_ = wall + *seconds;
  }
  if (const double seconds = patience(); seconds > 0) pty_.wait(seconds);
}

void Runner::exchange() {
  in_.clear();
  pty_.read(in_);
  if (pty_.take_opened() && options_.reset_on_open) printer_->reset();
  if (!in_.empty()) printer_->feed(in_);
  out_ += printer_->take_output();
  if (options_.reset_on_open && !pty_.connected()) out_.clear();
  if (out_.empty()) return;
  // The clock is published before the words that it belongs to.
  if (clock_) clock_->publish(printer_->now());
  pty_.write(out_);
}

void Runner::let_time_pass(double wall) {
  const bool waiting = pty_.connected() && out_.empty() && printer_->waits_for_host();
  const bool idle = printer_->drained();
  const double allowed = pacer_.allowance(wall, waiting, idle, printer_->progress());
  if (pacer_.holding()) {
    due_ = printer_->now();
  } else if (std::isfinite(allowed)) {
    due_ = std::max(due_, printer_->now()) + allowed;
  } else {
    due_ = printer_->next_event();
    if (!std::isfinite(due_)) due_ = printer_->now();
  }
  if (pacer_.speed() == 1) return printer_->advance_to(due_);
  // One event at a time, with a look at the port after each: the next one may want the host's answer first.
  const double next = printer_->next_event();
  printer_->advance_to(std::min(due_, std::max(next, printer_->now())));
}

/// Wall seconds this turn may wait for input.
double Runner::patience() const {
  if (!out_.empty()) return 0.001;
  if (pacer_.holding()) return std::clamp(pacer_.grace_left(), 0.0, kTurn);
  const double next = printer_->next_event();
  const double speed = pacer_.speed();
  if (speed == 0) {
    const bool nothing = !std::isfinite(next) || (printer_->waits_for_host() && printer_->drained());
    return nothing ? 0.005 : 0;
  }
  if (!std::isfinite(next)) return kTurn;
  return std::clamp((next - due_) / speed, 0.0, kTurn);
}

std::string to_json(const Statistics& s) {
  const auto number = [](double v) { return fixed(v, 6); };
  std::string json = "{";
  const auto add = [&](const char* key, const std::string& value) {
    if (json.size() > 1) json += ',';
    json += '"' + std::string(key) + "\":" + value;
  };
  add("commands", std::to_string(s.commands));
  add("resends", std::to_string(s.resends));
  add("bytes_dropped", std::to_string(s.bytes_dropped));
  add("motion_s", number(s.motion_s));
  add("faults", std::to_string(s.faults));
  add("lines", std::to_string(s.lines));
  add("unknown", std::to_string(s.unknown));
  add("resets", std::to_string(s.resets));
  add("blocks", std::to_string(s.blocks));
  add("span_s", number(s.span_s));
  add("homing_s", number(s.homing_s));
  add("dwell_s", number(s.dwell_s));
  add("heating_s", number(s.heating_s));
  add("clock_s", number(s.clock_s));
  add("hotend_target", number(s.hotend_target));
  add("bed_target", number(s.bed_target));
  add("hotend", number(s.hotend));
  add("bed", number(s.bed));
  add("fan", number(s.fan));
  add("halted", s.halted ? "true" : "false");
  return json + "}";
}

}  // namespace voidpath::test::mock
