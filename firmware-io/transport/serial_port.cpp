#include "firmware-io/transport/serial_port.h"

#include "firmware-io/transport/fd_transport.h"
#include "firmware-io/transport/raw_tty.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include <fcntl.h>
#include <libserialport.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace voidpath::fw {
namespace {

struct FreePort {
  void operator()(sp_port* port) const { ::sp_free_port(port); }
};
using PortHandle = std::unique_ptr<sp_port, FreePort>;

bool is_pseudo_terminal(const std::string& path) { return path.starts_with("/dev/pts/"); }

std::string resolve(const std::string& path) {
  std::error_code error;
  const auto real = std::filesystem::canonical(path, error);
  if (error) throw PortError(path + ": " + error.message());
  return real.string();
}

// A descriptor of our own, configured through libserialport; -1 where it does not know the device.
int open_through_library(const std::string& device, int baud) {
  sp_port* raw = nullptr;
  if (::sp_get_port_by_name(device.c_str(), &raw) != SP_OK) return -1;
  const PortHandle port(raw);
  if (::sp_open(port.get(), SP_MODE_READ_WRITE) != SP_OK) return -1;
  int fd = -1;
  const bool set = ::sp_set_baudrate(port.get(), baud) == SP_OK && ::sp_set_bits(port.get(), 8) == SP_OK &&
                   ::sp_set_parity(port.get(), SP_PARITY_NONE) == SP_OK &&
                   ::sp_set_stopbits(port.get(), 1) == SP_OK &&
                   ::sp_set_flowcontrol(port.get(), SP_FLOWCONTROL_NONE) == SP_OK &&
                   ::sp_get_port_handle(port.get(), &fd) == SP_OK;
  const int own = set ? ::fcntl(fd, F_DUPFD_CLOEXEC, 0) : -1;
  ::sp_close(port.get());  // the duplicate keeps the line open: DTR does not fall
  return own;
}

int open_plainly(const std::string& path, const std::string& device) {
  const int fd = ::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) throw PortError(path + ": " + std::strerror(errno));
  return fd;
}

}  // namespace

std::unique_ptr<Transport> open_serial_port(const std::string& path, int baud, bool hang_up) {
  const std::string device = resolve(path);
  const bool pseudo = is_pseudo_terminal(device);  // has no modem lines, which the library insists on
  int fd = pseudo ? -1 : open_through_library(device, baud);
  if (fd < 0) fd = open_plainly(path, device);
  auto transport = std::make_unique<FdTransport>(fd, path);
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) throw PortError(path + ": in use by another program");
  // A pseudo terminal outlives us in its owner's hands and would stay locked.
  if (!pseudo) ::ioctl(fd, TIOCEXCL);
  if (const int error = make_raw(fd, baud, hang_up))
    throw PortError(path + ": cannot set up the line: " + std::strerror(error));
  make_low_latency(fd);
  return transport;
}

}  // namespace voidpath::fw
