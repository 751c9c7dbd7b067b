// How fast short moves go out over S3G: the real driver against the mock, on a modelled wire of 115200 baud
// with several round trips, on an invented clock; beside it the wire's own limit, and what our side costs in
// CPU.
#include "tests/firmware-io/s3g_bench.h"

#include <cstdio>
#include <ctime>

using namespace voidpath;

namespace {

constexpr std::size_t kMoves = 20000;

std::vector<std::string> file() {
  std::vector<std::string> out = {"G92 X0 Y0 Z0", "M83"};
  // 0.1 mm forth and back in sweeps: faster than any wire feeds.
  for (std::size_t i = 0; i < kMoves; ++i) {
    const double at = static_cast<double>(i % 2000 < 1000 ? i % 1000 : 1000 - i % 1000) * 0.1;
    out.push_back("G1 X" + std::to_string(at) + " E0.005 F12000");
  }
  return out;
}

double cpu_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

int main() {
  std::printf("round trip   moves/s   wire's limit   share   failures\n");
  bool fast_enough = true;
  for (const double round_trip_s : {0.0, 0.001, 0.002, 0.016}) {
    test::mock::S3gOptions options;
    options.baud = 115200;
    options.round_trip_s = round_trip_s;
    test::S3gBench bench(options);
    if (!bench.connect()) return 1;
    bench.print(file());
    bench.run_until([&] { return bench.executed.size() > 500; });
    const double begun_s = bench.t;
    const std::size_t before = bench.executed.size();
    bench.run_until([&] { return bench.executed.size() > kMoves - 500; });
    const double rate = static_cast<double>(bench.executed.size() - before) / (bench.t - begun_s);
    const double limit = 1 / (39 * 10 / 115200.0 + round_trip_s);
    if (round_trip_s == 0.001) fast_enough = rate >= 220;
    std::printf("%7.0f ms   %7.1f   %12.1f   %4.1f %%   %zu\n", 1000 * round_trip_s, rate, limit,
                100 * rate / limit, static_cast<std::size_t>(bench.count<fw::PrintFailed>()));
  }

  // Our side alone: translation and framing, as for a file on its way.
  const auto lines = file();
  fw::s3g::Encoder encoder((fw::s3g::Machine()));
  const double begun_s = cpu_s();
  std::size_t bytes = 0;
  for (const std::string& line : lines) {
    for (const auto& action : encoder.encode(line).actions) bytes += fw::s3g::frame(action.payload).size();
  }
  std::printf("translating and framing: %.3f CPU s per 100,000 lines (%zu bytes)\n",
              (cpu_s() - begun_s) * 100000 / static_cast<double>(lines.size()), bytes);
  std::printf("at 1 ms: %s 220 moves/s\n", fast_enough ? "at least" : "LESS THAN");
  return fast_enough ? 0 : 1;
}
