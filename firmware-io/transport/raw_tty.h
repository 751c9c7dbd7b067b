#pragma once

/// Terminal settings beyond POSIX, kept apart because their kernel header collides with <termios.h>.
namespace voidpath::fw {

/// Raw bytes, 8N1, no flow control, any baud rate, reads that wait for a byte (so that 0 means hang-up).
/// `hang_up`: DTR falls when the last descriptor is closed. 0, or errno.
int make_raw(int fd, int baud, bool hang_up = true) noexcept;

/// Asks a USB bridge to hand bytes on at once instead of after its 16 ms. Best effort.
void make_low_latency(int fd) noexcept;

}  // namespace voidpath::fw
