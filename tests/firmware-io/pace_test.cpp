#include "tests/firmware-io/mock_bench.h"

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using namespace voidpath::test;

TEST_CASE("oks are left lying while the wire is busy, and not where there is no wire", "[pace]") {
  const bool wire = GENERATE(true, false);
  auto printer = mock::make_mock().instant_moves();
  if (wire) printer.baud(115200).round_trip(0.001);
  MockBench bench(printer.build());
  REQUIRE(bench.run_until([&] { return bench.count<LimitsKnown>() == 1; }));
  std::vector<std::string> file;
  for (int i = 0; i < 400; ++i) file.push_back("G1 X" + std::to_string(i % 200) + " Y12.345 F6000");
  bench.print(file);
  // An early ok is what tells: here the first few lines are still taken to stand on a wire.
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() >= 100; }));
  int rests = 0;
  REQUIRE(bench.run_until([&] {
    rests += bench.driver.unhurried_until() > bench.t() ? 1 : 0;
    return bench.over();
  }));
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK((rests > 100) == wire);
}
