#pragma once

#include "tests/firmware-io/driver_bench.h"

#include <string>
#include <vector>

/// What tests of the driver print.
namespace voidpath::test {

using Lines = std::vector<std::string>;

inline Lines moves(int n) {
  Lines out;
  for (int i = 0; i < n; ++i) {
    out.push_back("G1 X" + std::to_string(i * 7919 % 2000) + " Y" + std::to_string(i) + " E" +
                  std::to_string(i * 31 % 777));
  }
  return out;
}

inline Lines operator+(Lines a, const Lines& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

inline bool over(const DriverBench& bench) {
  return bench.count<fw::PrintFinished>() + bench.count<fw::PrintFailed>() +
             bench.count<fw::PrintCancelled>() >
         0;
}

}  // namespace voidpath::test
