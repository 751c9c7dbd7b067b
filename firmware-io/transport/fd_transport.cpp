#include "firmware-io/transport/fd_transport.h"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include <sys/socket.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

namespace voidpath::fw {
namespace {

bool just_not_now(int error) { return error == EAGAIN || error == EWOULDBLOCK || error == EINTR; }

std::string explain(const std::string& name, const char* what, int error) {
  return name + ": " + what + ": " + std::strerror(error);
}

}  // namespace

FdTransport::FdTransport(int fd, std::string name) : fd_(fd), name_(std::move(name)) {
  struct stat info {};
  socket_ = ::fstat(fd, &info) == 0 && S_ISSOCK(info.st_mode);
}

FdTransport::~FdTransport() { ::close(fd_); }

std::size_t FdTransport::read(std::span<char> into) {
  const ssize_t n = ::read(fd_, into.data(), into.size());
  if (n > 0) return static_cast<std::size_t>(n);
  if (n == 0) throw PortError(name_ + ": the far end is gone");
  if (just_not_now(errno)) return 0;
  throw PortError(explain(name_, "cannot read", errno));
}

std::size_t FdTransport::write(std::string_view bytes) {
  const ssize_t n = socket_ ? ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL)
                            : ::write(fd_, bytes.data(), bytes.size());
  if (n >= 0) return static_cast<std::size_t>(n);
  if (just_not_now(errno)) return 0;
  throw PortError(explain(name_, "cannot write", errno));
}

void FdTransport::drop_output() noexcept { ::tcflush(fd_, TCOFLUSH); }

}  // namespace voidpath::fw
