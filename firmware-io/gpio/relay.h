#pragma once

#include "firmware-io/gpio/pins.h"

#include <atomic>
#include <cstdint>
#include <memory>

namespace voidpath::fw {

/// The relay of a printer's power supply. Off until told otherwise and whenever it goes. Any thread; waits on
/// no lock, so that whoever stops a printer never waits for whoever starts it.
class Relay {
 public:
  explicit Relay(std::unique_ptr<OutputPin> pin) : pin_(std::move(pin)) {}
  ~Relay() { off(); }
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  /// Off, and on() does nothing until the cut is forgiven. Never throws: false where the pin refused.
  bool cut() noexcept;
  bool off() noexcept;
  /// False while a cut stands. Throws PinError.
  bool on();
  bool is_cut() const noexcept { return cuts_.load() != forgiven_.load(); }
  bool is_on() const noexcept { return on_.load() == std::uint64_t{cuts_.load()} + 1 && !is_cut(); }

  /// How many cuts there have been: what forgive() is to forgive. A cut that comes after stands.
  std::uint32_t cuts() const noexcept { return cuts_.load(); }
  void forgive(std::uint32_t cuts) noexcept { forgiven_.store(cuts); }

 private:
  bool drive_off() noexcept;

  std::unique_ptr<OutputPin> pin_;
  std::atomic<std::uint32_t> cuts_{0};
  std::atomic<std::uint32_t> forgiven_{0};
  std::atomic<std::uint64_t> on_{0};  ///< 0: off; else one more than the cuts there had been when it went on
};

}  // namespace voidpath::fw
