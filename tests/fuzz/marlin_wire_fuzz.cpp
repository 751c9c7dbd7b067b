#include "tests/fuzz/marlin_wire_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  voidpath::test::fuzz_marlin_wire(data, size);
  return 0;
}
