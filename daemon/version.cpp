#include "daemon/version.h"

namespace voidpath::daemon {

const char* version() noexcept { return VOIDPATH_VERSION; }

}  // namespace voidpath::daemon
