#include "firmware-io/transport/raw_tty.h"

#include <cerrno>

#include <asm/termbits.h>
#include <linux/serial.h>
#include <sys/ioctl.h>

namespace voidpath::fw {

int make_raw(int fd, int baud, bool hang_up) noexcept {
  termios2 tty{};
  if (::ioctl(fd, TCGETS2, &tty) != 0) return errno;
  tty.c_iflag = IGNBRK;
  tty.c_oflag = 0;
  tty.c_lflag = 0;
  constexpr tcflag_t kOwnRate = BOTHER;  // the rates stand in c_ispeed and c_ospeed
  tty.c_cflag = CS8 | CREAD | CLOCAL | kOwnRate | (kOwnRate << IBSHIFT);
  // When we die, DTR falls, and the next opening resets the board: its heaters go off.
  if (hang_up) tty.c_cflag |= HUPCL;
  tty.c_ispeed = tty.c_ospeed = static_cast<speed_t>(baud);
  tty.c_cc[VMIN] = 1;
  tty.c_cc[VTIME] = 0;
  return ::ioctl(fd, TCSETS2, &tty) == 0 ? 0 : errno;
}

void make_low_latency(int fd) noexcept {
  serial_struct serial{};
  if (::ioctl(fd, TIOCGSERIAL, &serial) != 0) return;
  serial.flags = static_cast<int>(static_cast<unsigned>(serial.flags) | ASYNC_LOW_LATENCY);
  ::ioctl(fd, TIOCSSERIAL, &serial);
}

}  // namespace voidpath::fw
