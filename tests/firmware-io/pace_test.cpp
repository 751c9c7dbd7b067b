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

TEST_CASE("one awakening serves two lines and more, and the wire never runs dry for it", "[pace]") {
  const double baud = GENERATE(115200.0, 250000.0);
  marlin::DriverOptions options;
  options.byte_s = 10 / baud;
  MockBench bench(mock::make_mock().instant_moves().cold_extrusion().baud(baud).round_trip(0.001).build(),
                  options);
  REQUIRE(bench.run_until([&] { return bench.count<LimitsKnown>() == 1; }));
  std::vector<std::string> file;
  for (int i = 0; i < 1500; ++i) {
    const std::string digits = std::to_string(100 + i % 800);
    file.push_back("G1 X1" + digits + " Y20." + digits.substr(0, static_cast<std::size_t>(i % 4)) + " E.0" +
                   digits);
  }
  std::size_t bytes = 0;
  int reads = 0;
  bench.on_output = [&](const std::string& out) { bytes += out.size(); };
  bench.on_input = [&](const std::string&) { ++reads; };
  bench.rests = true;
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() >= 400; }));
  const int lines_before = bench.count<LineDone>();
  const double begin = bench.t();
  bytes = 0;
  reads = 0;
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() >= 1400; }));
  const double lines = bench.count<LineDone>() - lines_before;
  CHECK(reads <= (baud > 200000 ? 0.45 : 0.35) * lines);
  CHECK(static_cast<double>(bytes) * options.byte_s >= 0.99 * (bench.t() - begin));
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(bench.printer.statistics().bytes_dropped == 0);
}

namespace {

/// What a stretch of a print made of its wire.
struct Share {
  double wire = 0;   ///< of what it can carry
  double reads = 0;  ///< a line
};

Share share_of(MockBench& bench, int lines, double byte_s) {
  std::size_t bytes = 0;
  int reads = 0;
  bench.on_output = [&](const std::string& out) { bytes += out.size(); };
  bench.on_input = [&](const std::string&) { ++reads; };
  const int before = bench.count<LineDone>();
  const double begin = bench.t();
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() >= before + lines; }));
  return {static_cast<double>(bytes) * byte_s / (bench.t() - begin), static_cast<double>(reads) / lines};
}

}  // namespace

TEST_CASE("a wire is kept full with few awakenings though its pace is not quite what its name says",
          "[pace]") {
  const double baud = 115200, off = GENERATE(-0.01, -0.0015, 0.0015, 0.02);
  marlin::DriverOptions options;
  options.byte_s = 10 / baud;
  MockBench bench(
      mock::make_mock().instant_moves().cold_extrusion().baud(baud * (1 + off)).round_trip(0.001).build(),
      options);
  REQUIRE(bench.run_until([&] { return bench.count<LimitsKnown>() == 1; }));
  std::vector<std::string> file;
  for (int i = 0; i < 4000; ++i) {
    const std::string digits = std::to_string(100 + i % 800);
    file.push_back("G1 X1" + digits + " Y20." + digits.substr(0, static_cast<std::size_t>(i % 4)) + " E.0" +
                   digits);
  }
  bench.rests = true;
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() >= 1500; }));
  const Share share = share_of(bench, 2000, options.byte_s / (1 + off));
  CHECK(share.wire >= 0.99);
  CHECK(share.reads <= 0.5);
}

TEST_CASE("after slow moves the wire is full again at once", "[pace]") {
  const double baud = GENERATE(115200.0, 250000.0);
  marlin::DriverOptions options;
  options.byte_s = 10 / baud;
  MockBench bench(mock::make_mock().cold_extrusion().baud(baud).round_trip(0.001).build(), options);
  REQUIRE(bench.run_until([&] { return bench.count<LimitsKnown>() == 1; }));
  constexpr int kSlow = 600;
  std::vector<std::string> file;
  for (int i = 0; i < kSlow; ++i) file.push_back("G1 X" + std::to_string(10 + 2 * (i % 2)) + " Y20 F4000");
  // Shorter than what the wire takes for their text.
  for (int i = 0; i < 1000; ++i) file.push_back("G1 X" + std::to_string(12 + 0.03 * i) + " Y20.1234 E.0123");
  bench.rests = true;
  bench.print(file);
  // What stood in the planner is printed first.
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() >= kSlow + 60; }));
  CHECK(share_of(bench, 200, options.byte_s).wire >= 0.9);
}
