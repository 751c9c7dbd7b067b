#pragma once

#include "firmware-io/transport/transport.h"

#include <memory>
#include <string>

namespace voidpath::fw {

/// Opens a tty for us alone: raw, 8N1, any baud rate the driver can make. `path` may be a link
/// (/dev/serial/by-id/...) or a pseudo terminal. Opening raises DTR, which resets many boards; without
/// `hang_up` it stays raised when the port is closed, so that no later opening does.
/// Throws PortError.
std::unique_ptr<Transport> open_serial_port(const std::string& path, int baud, bool hang_up = true);

}  // namespace voidpath::fw
