// libgpiod 1.x: a line lives as long as its open chip, so each pin keeps a chip of its own.
#include "firmware-io/gpio/find_line.h"
#include "firmware-io/gpio/pins.h"

#include <cerrno>

#include <fcntl.h>
#include <gpiod.h>
#include <poll.h>

namespace voidpath::fw {
namespace {

struct CloseChip {
  void operator()(gpiod_chip* chip) const { ::gpiod_chip_close(chip); }
};
using ChipHandle = std::unique_ptr<gpiod_chip, CloseChip>;

gpiod::ChipReader reader() {
  return {[](const std::string& path) -> std::optional<gpiod::ChipFacts> {
            const ChipHandle chip(::gpiod_chip_open(path.c_str()));
            if (!chip) return std::nullopt;
            return gpiod::ChipFacts{::gpiod_chip_name(chip.get()), ::gpiod_chip_label(chip.get()),
                                    ::gpiod_chip_num_lines(chip.get())};
          },
          [](const std::string& path, const std::string& line) -> std::optional<unsigned> {
            const ChipHandle chip(::gpiod_chip_open(path.c_str()));
            gpiod_line* found = chip ? ::gpiod_chip_find_line(chip.get(), line.c_str()) : nullptr;
            return found ? std::optional(::gpiod_line_offset(found)) : std::nullopt;
          }};
}

int flags_of(const PinOptions& pin) {
  int flags = pin.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
  if (pin.bias == Bias::disabled) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE;
  if (pin.bias == Bias::pull_up) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP;
  if (pin.bias == Bias::pull_down) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN;
  return flags;
}

/// A requested line; closing the chip releases it.
class Line {
 public:
  Line(const PinOptions& pin, const std::string& use, int type, bool active) : pin_(pin) {
    const auto place = gpiod::find_line(pin, reader());
    chip_.reset(::gpiod_chip_open(place.path.c_str()));
    line_ = chip_ ? ::gpiod_chip_get_line(chip_.get(), place.offset) : nullptr;
    const gpiod_line_request_config config{use.c_str(), type, flags_of(pin)};
    if (line_ == nullptr || ::gpiod_line_request(line_, &config, active ? 1 : 0) != 0)
      gpiod::refuse(pin, errno);
  }
  bool active() const {
    const int value = ::gpiod_line_get_value(line_);
    if (value < 0) gpiod::refuse(pin_, errno);
    return value == 1;
  }
  gpiod_line* get() const noexcept { return line_; }
  const PinOptions& pin() const noexcept { return pin_; }

 private:
  PinOptions pin_;
  ChipHandle chip_;
  gpiod_line* line_ = nullptr;
};

class Input final : public InputPin {
 public:
  Input(const PinOptions& pin, const std::string& use)
      : line_(pin, use, GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES, false),
        fd_(::gpiod_line_event_get_fd(line_.get())) {
    if (fd_ < 0) gpiod::refuse(pin, errno);
  }
  bool active() const override { return line_.active(); }
  int fd() const noexcept override { return fd_; }
  std::optional<Edge> next_edge() override {
    pollfd waiting{fd_, POLLIN, 0};
    if (::poll(&waiting, 1, 0) <= 0) return std::nullopt;
    gpiod_line_event event{};
    if (::gpiod_line_event_read_fd(fd_, &event) != 0) gpiod::refuse(line_.pin(), errno);
    return Edge{event.event_type == GPIOD_LINE_EVENT_RISING_EDGE,
                static_cast<double>(event.ts.tv_sec) + static_cast<double>(event.ts.tv_nsec) * 1e-9};
  }

 private:
  Line line_;
  int fd_;
};

class Output final : public OutputPin {
 public:
  Output(const PinOptions& pin, const std::string& use, bool active)
      : line_(pin, use, GPIOD_LINE_REQUEST_DIRECTION_OUTPUT, active) {}
  // The library sends one ioctl and notes the value in an int nobody reads: safe from any thread.
  void set(bool active) override {
    if (::gpiod_line_set_value(line_.get(), active ? 1 : 0) != 0) gpiod::refuse(line_.pin(), errno);
  }
  bool active() const override { return line_.active(); }

 private:
  Line line_;
};

class KernelPins final : public Pins {
 public:
  std::unique_ptr<InputPin> input(const PinOptions& pin, const std::string& use) override {
    return std::make_unique<Input>(pin, use);
  }
  std::unique_ptr<OutputPin> output(const PinOptions& pin, const std::string& use, bool active) override {
    return std::make_unique<Output>(pin, use, active);
  }
};

}  // namespace

std::unique_ptr<Pins> kernel_pins() { return std::make_unique<KernelPins>(); }

}  // namespace voidpath::fw
