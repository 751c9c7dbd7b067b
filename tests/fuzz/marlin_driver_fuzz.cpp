#include "tests/fuzz/marlin_driver_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  voidpath::test::fuzz_marlin_driver(data, size);
  return 0;
}
