#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string_view>

namespace voidpath::fw {

/// The far end is gone, or a port cannot be opened; what() says which port and why.
class PortError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Bytes to and from a printer, never blocking. One thread.
class Transport {
 public:
  virtual ~Transport() = default;
  /// For poll(): readable when bytes have come or the far end is gone.
  virtual int fd() const noexcept = 0;
  /// How many bytes were read; 0: none there now. Throws PortError when the far end is gone.
  virtual std::size_t read(std::span<char> into) = 0;
  /// How many bytes were taken; 0: none now. Throws PortError when the far end is gone.
  virtual std::size_t write(std::string_view bytes) = 0;
  /// Forgets what was taken and has not left yet, as far as that can be done.
  virtual void drop_output() noexcept = 0;
};

/// Throws PortError.
using OpenTransport = std::function<std::unique_ptr<Transport>()>;

}  // namespace voidpath::fw
