#pragma once

#include "tests/bench/stream/wire_printer.h"

#include <string>

namespace voidpath::bench {

/// CPU of the dialogue alone: a print through it in memory, where each line is met by `ok` as soon as it is
/// written. No thread, no port, hardly a system call.
CpuUse print_in_memory(const std::string& file, int window);

}  // namespace voidpath::bench
