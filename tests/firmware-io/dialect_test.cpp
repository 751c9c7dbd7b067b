#include "tests/firmware-io/mock_bench.h"

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using namespace voidpath::test;

TEST_CASE("a printer's own settings are known after connecting, in the words of every Marlin", "[dialect]") {
  const std::string firmware = GENERATE("marlin2", "marlin1", "prusa");
  const bool classic = GENERATE(false, true);
  CAPTURE(firmware, classic);
  mock::MotionSettings motion;
  motion.classic_jerk = classic;
  motion.max_speed = {301, 302, 13, 44};
  motion.retract_acceleration = 1234;
  mock::Options options = mock::make_mock().firmware(firmware).motion(motion).build();
  options.volume_mm = {235, 232, 283};
  MockBench bench(options);
  REQUIRE(bench.run_until([&] { return bench.count<LimitsKnown>() == 1; }));
  REQUIRE(bench.count<Connected>() == 1);
  const FirmwareLimits& limits = bench.find<LimitsKnown>()->limits;
  CHECK(limits.max_feed_mm_s == PerAxis{301, 302, 13, 44});
  CHECK(limits.steps_per_mm[2] == motion.steps_per_mm[2]);
  CHECK(limits.max_acceleration_mm_s2[3] == motion.max_acceleration[3]);
  CHECK(limits.retract_acceleration_mm_s2 == 1234);
  CHECK(limits.jerk_mm_s[0].has_value() == classic);
  CHECK(limits.junction_deviation_mm.has_value() != classic);
  REQUIRE(limits.volume);
  CHECK(limits.volume->max_mm == std::array<double, 3>{235, 232, 283});
  for (const Event& event : bench.events)
    if (const auto* message = std::get_if<Message>(&event.what))
      CHECK(message->text.find("M92") == std::string::npos);
}
