#include "engine/run/context.h"

#include <algorithm>
#include <thread>

namespace voidpath::run {

unsigned Context::thread_count() const {
  return threads != 0 ? threads : std::max(1u, std::thread::hardware_concurrency());
}

}  // namespace voidpath::run
