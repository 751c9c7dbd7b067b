#include "tests/firmware-io/mock_bench.h"

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using namespace voidpath::test;

namespace {

void replace(std::string& text, std::string_view what, std::string_view by) {
  const auto at = text.find(what);
  if (at != text.npos) text.replace(at, what.size(), by);
}

}  // namespace

TEST_CASE("a firmware that goes on unpacking though it was told to stop is told again", "[meatpack]") {
  MockBench bench(mock::make_mock().meatpack().instant_moves().cold_extrusion().build());
  int offs = 0;
  bench.to_printer = [&](std::string bytes) {
    replace(bytes, "\xFF\xFF\xF7", "");  // never without blanks: no agreement
    const bool off = bytes.starts_with("\xFF\xFF\xF9\n");
    if (off && ++offs == 4) replace(bytes, "\xFF\xFF\xF9\n", "\xFF\xF9\n");
    return bytes;
  };
  REQUIRE(bench.connect());
  bench.print({"G90", "G1 X10 F600", "G1 X20", "G1 X30"});
  REQUIRE(bench.run_until([&] { return bench.over(); }, 200));
  CHECK(offs > 4);
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(std::count(bench.log.begin(), bench.log.end(), "G1X30") == 1);
}

TEST_CASE("a word to unpack no more that is lost on its way is missed at once", "[meatpack]") {
  mock::Fault garble;
  garble.kind = mock::FaultKind::kGarbleLine;
  garble.at = 60;
  MockBench bench(
      mock::make_mock().baud(115200).meatpack().instant_moves().cold_extrusion().fault(garble).build());
  REQUIRE(bench.connect());
  bench.run_for(2);
  bool lost = false;
  bench.to_printer = [&](std::string bytes) {
    if (!lost && bytes.find("\xFF\xFF\xF9\n") != bytes.npos) {
      replace(bytes, "\xFF\xFF\xF9\n", "\xFF\xF9\n");
      lost = true;
    }
    return bytes;
  };
  const double begun = bench.t();
  bench.print(std::vector<std::string>(200, "G1 X10 F600"));
  REQUIRE(bench.run_until([&] { return bench.over(); }, 100));
  CHECK(lost);
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(bench.t() - begun < 2);
}

TEST_CASE("an emergency stop right after a reconnection is heard by a firmware that still unpacks",
          "[meatpack]") {
  MockBench bench(mock::make_mock().meatpack().instant_moves().cold_extrusion().build());
  REQUIRE(bench.connect());
  bench.run_for(2);
  bench.driver.lost("cable");
  bench.driver.opened(bench.t());
  bench.driver.halt("button", bench.t());
  CHECK(bench.run_until([&] { return bench.printer.halted(); }, 2));
}
