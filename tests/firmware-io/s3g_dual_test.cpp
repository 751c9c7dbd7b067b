#include "tests/firmware-io/s3g_prints.h"

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using namespace voidpath::test;

namespace {

s3g::DriverOptions dual() {
  s3g::DriverOptions options;
  options.machine.extruders = 2;
  options.machine.heated_bed = true;
  return options;
}

mock::S3gOptions dual_printer() {
  mock::S3gOptions o = real_wire();
  o.tools = 2;
  o.heated_bed = true;
  return o;
}

const Lines kHeat = {"M136", "M140 S60", "M104 S100 T0", "M104 S90 T1", "G92 X0 Y0 Z0",
                     "M83",  "M190 S60", "M133 T0",      "M133 T1"};

}  // namespace

TEST_CASE("two hotends and a bed are heated, waited for and told of", "[s3g]") {
  S3gBench bench(dual_printer(), dual());
  REQUIRE(bench.connect());
  const Lines file = kHeat + moves(20) + Lines{"T1"} + moves(20, 2) + Lines{"T0"} + moves(20, 3);
  REQUIRE(bench.print_through(file));
  CHECK(bench.failure().empty());
  CHECK(bench.count<PrintFinished>() == 1);
  check_executed(bench, file, dual().machine);
  const auto& told =
      std::get<Temperatures>(std::find_if(bench.events.rbegin(), bench.events.rend(), [](const Event& e) {
                               return std::holds_alternative<Temperatures>(e.what);
                             })->what);
  CHECK(told.sensors.at("T0").target_c == 100);
  CHECK(told.sensors.at("T1").target_c == 90);
  CHECK(told.sensors.at("B").target_c == 60);
}

TEST_CASE("after a print that ended on T1 the next one's T0 is T0", "[s3g]") {
  S3gBench bench(dual_printer(), dual());
  REQUIRE(bench.connect());
  REQUIRE(bench.print_through(kHeat + moves(5) + Lines{"T1"} + moves(5)));
  for (const Lines& lines : {Lines{"T0"}, Lines{}}) {
    bench.forget_events();
    bench.executed.clear();
    const Lines file = Lines{"M136"} + lines + Lines{"M132 X Y Z A B", "G1 X0 Y0 Z10", "M83"} + moves(5) +
                       Lines{"T1"} + moves(5);
    REQUIRE(bench.print_through(file));
    CHECK(bench.count<PrintFinished>() == 1);
    check_executed(bench, file, dual().machine);
  }
}
