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

// Through libserialport, which may not know the device. The port is open already, and stays so: DTR does not
// fall.
void set_line(const std::string& device, int baud) {
  sp_port* raw = nullptr;
  if (::sp_get_port_by_name(device.c_str(), &raw) != SP_OK) return;
  const PortHandle port(raw);
  if (::sp_open(port.get(), SP_MODE_READ_WRITE) != SP_OK) return;
  ::sp_set_baudrate(port.get(), baud);
  ::sp_set_bits(port.get(), 8);
  ::sp_set_parity(port.get(), SP_PARITY_NONE);
  ::sp_set_stopbits(port.get(), 1);
  ::sp_set_flowcontrol(port.get(), SP_FLOWCONTROL_NONE);
  ::sp_close(port.get());
}

int open_port(const std::string& path, const std::string& device) {
  const int fd = ::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) throw PortError(path + ": " + std::strerror(errno));
  return fd;
}

}  // namespace

std::unique_ptr<Transport> open_serial_port(const std::string& path, int baud, bool hang_up) {
  const std::string device = resolve(path);
  const int fd = open_port(path, device);
  auto transport = std::make_unique<FdTransport>(fd, path);
  // Before anything is set: whoever uses it goes on as before.
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) throw PortError(path + ": in use by another program");
  const bool pseudo = is_pseudo_terminal(device);  // has no modem lines, which the library insists on
  if (!pseudo) set_line(device, baud);
  // A pseudo terminal outlives us in its owner's hands and would stay locked.
  if (!pseudo) ::ioctl(fd, TIOCEXCL);
  if (const int error = make_raw(fd, baud, hang_up))
    throw PortError(path + ": cannot set up the line: " + std::strerror(error));
  make_low_latency(fd);
  return transport;
}

}  // namespace voidpath::fw
