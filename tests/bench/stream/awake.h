#pragma once

#include <vector>

#include <sys/types.h>

namespace voidpath::bench {

/// While it lives no processor rests: one process for each turns idly round, behind all else. What a host
/// costs then is its own work; else the processors' ways back from sleep, their cold caches and low clock,
/// are charged to it as well.
class KeptAwake {
 public:
  KeptAwake();
  ~KeptAwake();
  KeptAwake(const KeptAwake&) = delete;
  KeptAwake& operator=(const KeptAwake&) = delete;

 private:
  std::vector<pid_t> spinners_;
};

}  // namespace voidpath::bench
