#pragma once

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

namespace voidpath::fw {

/// A pin cannot be had or has gone; what() names the pin, what is wrong and what to do about it.
class PinError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The resistor inside the chip.
enum class Bias { as_is, disabled, pull_up, pull_down };

struct PinOptions {
  std::string
      chip;  ///< device name ("gpiochip0"), path, or the chip's label; empty: any chip that has the line
  std::string line;  ///< offset, or the line's name
  bool active_low = false;
  Bias bias = Bias::as_is;
};

/// "GPIO17 of pinctrl-bcm2711", for messages.
std::string describe(const PinOptions& pin);

/// Everywhere below, active means what the pin's owner means by it: active_low has been seen to.
struct Edge {
  bool active = false;
  double at_s = 0;  ///< the kernel's stamp, CLOCK_MONOTONIC
};

/// An input with both edges. One thread.
class InputPin {
 public:
  virtual ~InputPin() = default;
  /// The level now. Throws PinError.
  virtual bool active() const = 0;
  /// For poll(): readable while an edge waits.
  virtual int fd() const noexcept = 0;
  /// The oldest edge that waits; never blocks. Throws PinError.
  virtual std::optional<Edge> next_edge() = 0;
};

/// An output. set() and active() may be called from any thread.
class OutputPin {
 public:
  virtual ~OutputPin() = default;
  /// Throws PinError.
  virtual void set(bool active) = 0;
  /// What the pin reads back. Throws PinError.
  virtual bool active() const = 0;
};

/// Where pins come from. Destroying a pin gives its line back; what becomes of an output then is the chip
/// driver's business.
class Pins {
 public:
  virtual ~Pins() = default;
  /// `use` is what other programs are told of who has the line. Throws PinError: no chip, no such line, line
  /// in use, no permission.
  virtual std::unique_ptr<InputPin> input(const PinOptions& pin, const std::string& use) = 0;
  /// Driven to `active` from the moment it is ours. Throws PinError.
  virtual std::unique_ptr<OutputPin> output(const PinOptions& pin, const std::string& use, bool active) = 0;
};

/// The kernel's GPIO chips, through libgpiod.
std::unique_ptr<Pins> kernel_pins();

}  // namespace voidpath::fw
