#pragma once

#include <cstdio>
#include <cstdlib>

namespace voidpath::test {

/// Unlike assert, also where NDEBUG is defined.
inline void require(bool holds, const char* what = "a law of the target does not hold") {
  if (holds) return;
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}

}  // namespace voidpath::test
