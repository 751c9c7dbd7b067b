#include "tests/firmware-io/soak.h"

#include <catch2/catch.hpp>

using namespace voidpath::test;

TEST_CASE("through every fault each line is taken once and in order, or the print ends with a reason",
          "[soak]") {
  int finished = 0, invisible = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const SoakPrint print = soak_print(seed);
    INFO(print.what << " / " << print.reason);
    CHECK(print.violation == "");
    finished += print.finished ? 1 : 0;
    invisible += print.invisible > 0 ? 1 : 0;
  }
  CHECK(finished > 150);
  CHECK(invisible < 60);
}

TEST_CASE(
    "through every fault of a MakerBot's wire each command is executed once, or the print ends with a reason",
    "[soak]") {
  int finished = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const SoakPrint print = s3g_soak_print(seed);
    INFO(print.what << " / " << print.reason);
    CHECK(print.violation == "");
    finished += print.finished ? 1 : 0;
  }
  CHECK(finished > 20);
}

TEST_CASE("with one damaged byte in 10 kB every print finishes", "[soak]") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SoakPrint print = noisy_print(seed);
    INFO(print.what << " / " << print.reason << ", " << print.resends << " resends");
    CHECK(print.violation == "");
    CHECK(print.finished);
  }
}

TEST_CASE("with one damaged byte in 10 kB nothing stands still for half a second", "[soak]") {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const SoakPrint print = noisy_print(seed);
    INFO(print.what << ", " << print.resends << " resends");
    CHECK(print.longest_gap_s <= 0.5);
  }
}
