#include "tests/fuzz/s3g_targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  voidpath::test::fuzz_s3g_encoder(data, size);
  return 0;
}
