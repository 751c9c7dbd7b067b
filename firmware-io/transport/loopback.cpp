#include "firmware-io/transport/loopback.h"

#include "firmware-io/transport/fd_transport.h"

#include <cerrno>
#include <cstring>
#include <string>

#include <sys/socket.h>

namespace voidpath::fw {

Loopback make_loopback() {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends) != 0) {
    throw PortError(std::string("loopback: ") + std::strerror(errno));
  }
  return {std::make_unique<FdTransport>(ends[0], "loopback host"),
          std::make_unique<FdTransport>(ends[1], "loopback device")};
}

}  // namespace voidpath::fw
