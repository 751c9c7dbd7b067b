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
  CHECK(std::get<Connected>(bench.first<Connected>()->what).firmware.extruders == 2);
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

TEST_CASE("a print that fails on its file is left like a cancelled one: lifted, all heaters off, motors free",
          "[s3g]") {
  s3g::DriverOptions options = dual();
  options.cancel_gcode = {"G91", "G1 Z5 F600", "G90"};
  S3gBench bench(dual_printer(), options);
  REQUIRE(bench.connect());
  REQUIRE(bench.print_through(kHeat + moves(20) + Lines{"G5 X1 Y1"}));
  CHECK_THAT(bench.failure(), Catch::Contains("G5 X1 Y1"));
  bench.run_for(10);
  CHECK(bench.mock.hotend(0).target() == 0);
  CHECK(bench.mock.hotend(1).target() == 0);
  CHECK(bench.mock.statistics().bed_target == 0);
  CHECK(bench.mock.position()[2] == 5 * 400);
  REQUIRE(bench.executed.size() > 2);
  CHECK(s3g::hex(bench.executed[bench.executed.size() - 2]) == "89 1F");
  CHECK(bench.mock.violations().empty());
}

TEST_CASE("a printer that restarted is only cooled: nobody knows where it stands", "[s3g]") {
  s3g::DriverOptions options = dual();
  options.cancel_gcode = {"G91", "G1 Z5 F600", "G90"};
  S3gBench bench(dual_printer(), options);
  REQUIRE(bench.connect());
  const Lines file = kHeat + moves(3);
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() == static_cast<int>(file.size()); }));
  // All is sent, and what is asked next is whether it knows of the build.
  bench.mock.reset();
  bench.executed.clear();
  REQUIRE(bench.run_until([&] { return bench.over(); }, 60));
  CHECK_THAT(bench.failure(), Catch::Contains("restarted"));
  bench.run_for(10);
  for (const std::string& payload : bench.executed) CHECK(static_cast<unsigned char>(payload[0]) != 155);
}
