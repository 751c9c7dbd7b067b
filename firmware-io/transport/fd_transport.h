#pragma once

#include "firmware-io/transport/transport.h"

#include <string>

namespace voidpath::fw {

/// Transport over a file descriptor it owns: a tty or one end of a socket pair.
class FdTransport : public Transport {
 public:
  /// `fd` is non-blocking; `name` is for messages.
  FdTransport(int fd, std::string name);
  ~FdTransport() override;
  FdTransport(const FdTransport&) = delete;
  FdTransport& operator=(const FdTransport&) = delete;

  int fd() const noexcept override { return fd_; }
  std::size_t read(std::span<char> into) override;
  std::size_t write(std::string_view bytes) override;
  void drop_output() noexcept override;

 private:
  int fd_;
  std::string name_;
  bool socket_ = false;
};

}  // namespace voidpath::fw
