#pragma once

#include <string>

namespace voidpath::bench {

/// The cheapest that a host can be, for what this machine takes for its system calls and sleeps alone: writes
/// a file's lines, framed beforehand, under a window of so many bytes, waits for oks and counts them. No
/// timers, no faults. `rest`: it sleeps until the wire has nearly run dry, instead of awaking for each ok.
int stream_bare(const std::string& port, int baud, const std::string& file, int window, bool rest);

}  // namespace voidpath::bench
