#include "tests/fuzz/marlin_targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  voidpath::test::fuzz_marlin_reply(data, size);
  return 0;
}
