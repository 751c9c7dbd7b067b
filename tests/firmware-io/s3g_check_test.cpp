#include "firmware-io/s3g/check_file.h"
#include "tests/firmware-io/s3g_prints.h"

#include <catch2/catch.hpp>

using namespace voidpath::test;
namespace s3g = voidpath::fw::s3g;

namespace {

/// What check_file() says of it; empty: nothing.
std::string refusal(const Lines& file, int extruders = 1, const std::stop_token& stop = {}) {
  MemorySource source(file);
  s3g::Machine machine;
  machine.extruders = extruders;
  try {
    s3g::check_file(source, machine, stop);
  } catch (const s3g::EncodeError& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("what a MakerBot cannot carry out is named by its line before anything is sent", "[s3g]") {
  const Lines good = kStart + moves(500);
  CHECK(refusal(good + kEnd) == "");
  CHECK(refusal({"G28", "G1 X1 Y1 Z1", "M117 hello"}) == "");
  CHECK_THAT(refusal(good + Lines{"G5 X1 Y1"} + kEnd),
             Catch::StartsWith("line " + std::to_string(good.size() + 1) + ": G5 X1 Y1: "));
  // What a line means is known from those before it alone.
  CHECK_THAT(refusal(kStart + Lines{"G28", "G1 X1"}), Catch::StartsWith("line 12: G1 X1: "));
  CHECK_THAT(refusal(kStart + Lines{"T1"}), Catch::StartsWith("line 11: T1: "));
  CHECK(refusal(kStart + Lines{"T1"}, 2) == "");
  // A stop of the printer is what such a file wants.
  CHECK(refusal(kStart + Lines{"M112"}) == "");
}

TEST_CASE("the check of a file ends when it is told to, and tells what the source does", "[s3g]") {
  std::stop_source stop;
  stop.request_stop();
  CHECK(refusal({"G5 X1 Y1"}, 1, stop.get_token()) == "");
  MemorySource broken(kStart);
  broken.fail_at = 3;
  CHECK_THROWS_WITH(s3g::check_file(broken, s3g::Machine{}, {}), "the file went away");
}
