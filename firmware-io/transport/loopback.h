#pragma once

#include "firmware-io/transport/transport.h"

#include <memory>

namespace voidpath::fw {

/// Two ends of a wire in memory. Destroying one end is pulling its cable.
struct Loopback {
  std::unique_ptr<Transport> host;
  std::unique_ptr<Transport> device;
};

/// Throws PortError when the system has no descriptors left.
Loopback make_loopback();

}  // namespace voidpath::fw
