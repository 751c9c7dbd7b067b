#pragma once

#include "tests/firmware-io/s3g_bench.h"

#include <random>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

/// Files for a MakerBot, and what printing them must come to.
namespace voidpath::test {

using Lines = std::vector<std::string>;

inline const Lines kStart = {"M136",        "M73 P0",         "G162 X Y F2000",
                             "G161 Z F900", "M132 X Y Z A B", "G1 X0 Y0 Z10 F3300",
                             "M104 S100",   "M109 S100",      "M83",
                             "G92 E0"};
inline const Lines kEnd = {"M104 S0", "M73 P100", "M137"};

inline Lines moves(int n, std::uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  Lines out;
  for (int i = 0; i < n; ++i) {
    const auto in = [&](int from, int to) {
      return from + static_cast<int>(random() % static_cast<unsigned>(to - from));
    };
    out.push_back("G1 X" + std::to_string(in(-90, 90)) + " Y" + std::to_string(in(-60, 60)) + " E0." +
                  std::to_string(in(100, 999)) + " F" + std::to_string(in(1200, 6000)));
    if (random() % 9 == 0) out.push_back("G1 E-1.5 F1500"), out.push_back("G1 E1.5 F1500");
    if (random() % 15 == 0) out.push_back("M106 S255");
  }
  return out;
}

inline Lines short_moves(int n) {
  Lines out;
  for (int i = 1; i <= n; ++i) out.push_back("G1 X" + std::to_string(i * 0.1) + " E0.005 F12000");
  return out;
}

inline Lines operator+(Lines a, const Lines& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// What a print must come to: the encoder's own actions, build notifications around them.
inline Lines expected(const Lines& file, const fw::s3g::Machine& machine = {}) {
  fw::s3g::Encoder encoder(machine);
  Lines out{encoder.build_start("voidpath").payload};
  for (const std::string& line : file) {
    for (const fw::s3g::Action& action : encoder.encode(line).actions) out.push_back(action.payload);
  }
  if (encoder.build_started()) out.push_back(encoder.build_end().payload);
  return out;
}

inline void check_executed(const S3gBench& bench, const Lines& file, const fw::s3g::Machine& machine = {}) {
  const Lines want = expected(file, machine);
  REQUIRE(bench.executed.size() == want.size());
  for (std::size_t i = 0; i < want.size(); ++i) {
    if (bench.executed[i] == want[i]) continue;
    INFO("command " << i);
    REQUIRE(fw::s3g::hex(bench.executed[i]) == fw::s3g::hex(want[i]));
  }
  CHECK(bench.mock.violations().empty());
}

/// Whatever became of the print before.
inline void check_next_print(S3gBench& bench) {
  bench.forget_events();
  bench.executed.clear();
  const Lines file = kStart + moves(30) + kEnd;
  REQUIRE(bench.print_through(file));
  CHECK(bench.count<fw::PrintFinished>() == 1);
  CHECK(bench.count<fw::Paused>() == 0);
  check_executed(bench, file);
}

inline mock::S3gOptions real_wire(std::vector<mock::Fault> faults = {}) {
  mock::S3gOptions o;
  o.baud = 115200;
  o.round_trip_s = 0.001;
  o.faults = std::move(faults);
  return o;
}

}  // namespace voidpath::test
