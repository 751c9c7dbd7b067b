// libgpiod 2.x: a request stands alone, its chip may be closed at once.
#include "firmware-io/gpio/find_line.h"
#include "firmware-io/gpio/pins.h"

#include <cerrno>

#include <gpiod.h>

namespace voidpath::fw {
namespace {

template <auto Free>
struct Release {
  template <class T>
  void operator()(T* handle) const {
    Free(handle);
  }
};
template <class T, auto Free>
using Handle = std::unique_ptr<T, Release<Free>>;

using ChipHandle = Handle<gpiod_chip, ::gpiod_chip_close>;
using InfoHandle = Handle<gpiod_chip_info, ::gpiod_chip_info_free>;
using SettingsHandle = Handle<gpiod_line_settings, ::gpiod_line_settings_free>;
using LineConfigHandle = Handle<gpiod_line_config, ::gpiod_line_config_free>;
using RequestConfigHandle = Handle<gpiod_request_config, ::gpiod_request_config_free>;
using RequestHandle = Handle<gpiod_line_request, ::gpiod_line_request_release>;
using BufferHandle = Handle<gpiod_edge_event_buffer, ::gpiod_edge_event_buffer_free>;

gpiod::ChipReader reader() {
  return {[](const std::string& path) -> std::optional<gpiod::ChipFacts> {
            const ChipHandle chip(::gpiod_chip_open(path.c_str()));
            const InfoHandle info(chip ? ::gpiod_chip_get_info(chip.get()) : nullptr);
            if (!info) return std::nullopt;
            return gpiod::ChipFacts{::gpiod_chip_info_get_name(info.get()),
                                    ::gpiod_chip_info_get_label(info.get()),
                                    static_cast<unsigned>(::gpiod_chip_info_get_num_lines(info.get()))};
          },
          [](const std::string& path, const std::string& line) -> std::optional<unsigned> {
            const ChipHandle chip(::gpiod_chip_open(path.c_str()));
            const int offset = chip ? ::gpiod_chip_get_line_offset_from_name(chip.get(), line.c_str()) : -1;
            return offset >= 0 ? std::optional(static_cast<unsigned>(offset)) : std::nullopt;
          }};
}

gpiod_line_bias bias_of(const PinOptions& pin) {
  switch (pin.bias) {
    case Bias::as_is:
      return GPIOD_LINE_BIAS_AS_IS;
    case Bias::disabled:
      return GPIOD_LINE_BIAS_DISABLED;
    case Bias::pull_up:
      return GPIOD_LINE_BIAS_PULL_UP;
    case Bias::pull_down:
      return GPIOD_LINE_BIAS_PULL_DOWN;
  }
  return GPIOD_LINE_BIAS_AS_IS;
}

gpiod_line_value value_of(bool active) {
  return active ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
}

/// A requested line.
class Line {
 public:
  Line(const PinOptions& pin, const std::string& use, bool output, bool active) : pin_(pin) {
    const auto place = gpiod::find_line(pin, reader());
    offset_ = place.offset;
    const ChipHandle chip(::gpiod_chip_open(place.path.c_str()));
    const SettingsHandle settings(::gpiod_line_settings_new());
    const LineConfigHandle lines(::gpiod_line_config_new());
    const RequestConfigHandle config(::gpiod_request_config_new());
    if (!chip || !settings || !lines || !config) gpiod::refuse(pin, errno);
    auto* s = settings.get();
    const bool set = ::gpiod_line_settings_set_direction(
                         s, output ? GPIOD_LINE_DIRECTION_OUTPUT : GPIOD_LINE_DIRECTION_INPUT) == 0 &&
                     (output ? ::gpiod_line_settings_set_output_value(s, value_of(active)) == 0
                             : ::gpiod_line_settings_set_edge_detection(s, GPIOD_LINE_EDGE_BOTH) == 0) &&
                     ::gpiod_line_settings_set_bias(s, bias_of(pin)) == 0;
    ::gpiod_line_settings_set_active_low(s, pin.active_low);
    ::gpiod_request_config_set_consumer(config.get(), use.c_str());
    if (!set || ::gpiod_line_config_add_line_settings(lines.get(), &offset_, 1, s) != 0)
      gpiod::refuse(pin, errno);
    request_.reset(::gpiod_chip_request_lines(chip.get(), config.get(), lines.get()));
    if (!request_) gpiod::refuse(pin, errno);
  }
  bool active() const {
    const auto value = ::gpiod_line_request_get_value(request_.get(), offset_);
    if (value == GPIOD_LINE_VALUE_ERROR) gpiod::refuse(pin_, errno);
    return value == GPIOD_LINE_VALUE_ACTIVE;
  }
  unsigned offset() const noexcept { return offset_; }
  gpiod_line_request* get() const noexcept { return request_.get(); }
  const PinOptions& pin() const noexcept { return pin_; }

 private:
  PinOptions pin_;
  unsigned offset_ = 0;
  RequestHandle request_;
};

class Input final : public InputPin {
 public:
  Input(const PinOptions& pin, const std::string& use)
      : line_(pin, use, false, false), buffer_(::gpiod_edge_event_buffer_new(1)) {
    if (!buffer_) gpiod::refuse(pin, errno);
  }
  bool active() const override { return line_.active(); }
  int fd() const noexcept override { return ::gpiod_line_request_get_fd(line_.get()); }
  std::optional<Edge> next_edge() override {
    const int waiting = ::gpiod_line_request_wait_edge_events(line_.get(), 0);
    if (waiting < 0) gpiod::refuse(line_.pin(), errno);
    if (waiting == 0) return std::nullopt;
    if (::gpiod_line_request_read_edge_events(line_.get(), buffer_.get(), 1) != 1)
      gpiod::refuse(line_.pin(), errno);
    gpiod_edge_event* event = ::gpiod_edge_event_buffer_get_event(buffer_.get(), 0);
    return Edge{::gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE,
                static_cast<double>(::gpiod_edge_event_get_timestamp_ns(event)) * 1e-9};
  }

 private:
  Line line_;
  BufferHandle buffer_;
};

class Output final : public OutputPin {
 public:
  Output(const PinOptions& pin, const std::string& use, bool active) : line_(pin, use, true, active) {}
  // One ioctl on a request that does not change: safe from any thread.
  void set(bool active) override {
    if (::gpiod_line_request_set_value(line_.get(), line_.offset(), value_of(active)) != 0)
      gpiod::refuse(line_.pin(), errno);
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
