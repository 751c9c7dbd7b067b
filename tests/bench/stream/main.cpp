// Hosts at one serial wire: how much of it they use, what they cost. Everybody talks to the same model: the
// mock printer on a pseudo terminal at the wire's pace, 1 ms round trip, 128-byte ring, 4-command queue,
// moves that take no time, so that only host and wire are measured.
#include "tests/bench/stream/awake.h"
#include "tests/bench/stream/bare_host.h"
#include "tests/bench/stream/memory_host.h"
#include "tests/bench/stream/our_host.h"
#include "tests/bench/stream/wire_printer.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <unistd.h>

namespace {

using namespace voidpath::bench;
namespace mock = voidpath::test::mock;

constexpr const char* kFirst = "M75";
constexpr const char* kLast = "M77";
constexpr double kBitsPerByte = 10;
constexpr double kRoundTrip_s = 0.001;
constexpr double kLimit_s = 1800;
// What may be unacknowledged: all but a byte of the receive ring that Marlin has, and of one that boards with
// memory to spare are built with.
constexpr int kWindow = 127, kWideWindow = 1023;

mock::Options printer(double baud, bool meatpack, int window = kWindow) {
  mock::Options o = mock::make_mock().baud(baud).round_trip(baud > 0 ? kRoundTrip_s : 0).build();
  o.rx_buffer = static_cast<std::size_t>(window) + 1;
  o.instant_moves = true;
  o.cold_extrusion = true;
  o.meatpack = meatpack;
  return o;
}

/// The moves of a G-code file between two marks: no heating, no homing, no comments.
struct Stream {
  std::filesystem::path file;
  std::size_t lines = 0;
  double framed_bytes = 0;  ///< as they stand in the file, numbered and summed, newline included
};

Stream moves_of(const std::string& gcode, std::size_t limit, const std::filesystem::path& scratch) {
  std::ifstream in(gcode);
  if (!in) throw std::runtime_error(gcode + ": cannot read");
  Stream stream;
  stream.file = scratch / (std::filesystem::path(gcode).stem().string() + ".moves.gcode");
  std::ofstream out(stream.file);
  out << kFirst << '\n';
  for (std::string line; stream.lines < limit && std::getline(in, line);) {
    line.erase(std::min(line.find(';'), line.size()));
    while (!line.empty() && (line.back() == ' ' || line.back() == '\r')) line.pop_back();
    if (!line.starts_with("G1") && !line.starts_with("G0") && !line.starts_with("G92")) continue;
    out << line << '\n';
    ++stream.lines;
    unsigned sum = 0;
    const std::string body = "N" + std::to_string(stream.lines + 5) + " " + line;
    for (const char c : body) sum ^= static_cast<unsigned char>(c);
    stream.framed_bytes += static_cast<double>(body.size() + 1 + std::to_string(sum).size() + 1);
  }
  out << kLast << '\n';
  if (stream.lines < 100) throw std::runtime_error(gcode + ": too few moves");
  return stream;
}

double per_100k(const CpuUse& cpu, const Stream& stream) {
  return cpu.total_s() / static_cast<double>(stream.lines) * 1e5;
}

struct Row {
  double lines_per_s = 0;
  double of_wire = 0;   ///< of the wire's bytes while it streamed
  double of_plain = 0;  ///< lines, against what the wire can carry of the file as it stands
  Outcome outcome;
};

Row measure(const char* name, const mock::Options& options, const std::vector<std::string>& host,
            const Stream& stream) {
  Row row;
  row.outcome = run_host(options, host, kFirst, kLast, kLimit_s);
  const Outcome& o = row.outcome;
  if (o.exit_code != 0 || o.stream_s <= 0)
    throw std::runtime_error(std::string(name) + " did not print the file");
  const double lines = static_cast<double>(stream.lines);
  row.lines_per_s = lines / o.stream_s;
  if (options.baud > 0) {
    row.of_wire = static_cast<double>(o.bytes) * kBitsPerByte / options.baud / o.stream_s;
    row.of_plain = row.lines_per_s / (options.baud / kBitsPerByte / (stream.framed_bytes / lines));
  }
  std::printf(
      "  %-24s %8.1f lines/s  %6.2f %% of the wire  %6.2f x the plain limit  %llu resends  %5.2f CPU s/100k "
      "lines (%.2f of the kernel, %.2f sleeps a line)  %5.1f MB\n",
      name, row.lines_per_s, 100 * row.of_wire, row.of_plain, static_cast<unsigned long long>(o.resends),
      per_100k(o.cpu, stream), o.cpu.kernel_s / lines * 1e5, o.cpu.sleeps / lines, o.resident_mb);
  std::fflush(stdout);
  return row;
}

int failures = 0;
void demand(bool holds, const char* what) {
  if (holds) return;
  ++failures;
  std::printf("  NOT MET: %s\n", what);
}

void compare(const std::string& self, const std::string& python, const Stream& stream, double baud) {
  const std::string rate = std::to_string(static_cast<int>(baud)), file = stream.file.string();
  const std::string window = std::to_string(kWindow);
  const Row plain =
      measure("voidpath", printer(baud, false), {self, "--host", "PORT", rate, file, window}, stream);
  demand(plain.of_wire >= 0.99, "99 % of the wire");
  demand(plain.outcome.resends == 0 && plain.outcome.bytes_dropped == 0, "no resends on a clean line");
  demand(per_100k(plain.outcome.cpu, stream) <= 2, "2 CPU s for 100,000 lines");
  demand(plain.outcome.resident_mb < 16, "16 MB");
  {
    const KeptAwake awake;
    measure("voidpath, cores awake", printer(baud, false), {self, "--host", "PORT", rate, file, window},
            stream);
  }
  const Row packed = measure("voidpath, MeatPack", printer(baud, true),
                             {self, "--host", "PORT", rate, file, window}, stream);
  demand(packed.of_plain >= 1.5, "1.5 x the plain limit with MeatPack");
  demand(packed.outcome.resends == 0, "no resends on a clean line, packed");
  measure("bare loop, each ok", printer(baud, false), {self, "--bare", "PORT", rate, file, window, "0"},
          stream);
  measure("bare loop, that rests", printer(baud, false), {self, "--bare", "PORT", rate, file, window, "1"},
          stream);
  if (python == "-") return;
  const Row core =
      measure("printcore", printer(baud, false), {"/usr/bin/python3", python, "PORT", rate, file}, stream);
  std::printf("  voidpath / printcore: %.2f x the lines, MeatPack %.2f x, %.0f x less CPU\n",
              plain.lines_per_s / core.lines_per_s, packed.lines_per_s / core.lines_per_s,
              core.outcome.cpu.total_s() / plain.outcome.cpu.total_s());
}

// As fast as host and terminal can, as with a board that has its own USB: there the rate that is named means
// nothing. And the dialogue alone.
void unpaced(const std::string& self, const Stream& stream) {
  const std::string file = stream.file.string(), rate = "115200";
  for (const int bytes : {kWindow, kWideWindow}) {
    std::printf("  window of %d bytes\n", bytes);
    const std::string window = std::to_string(bytes);
    const Row free =
        measure("voidpath", printer(0, false, bytes), {self, "--host", "PORT", rate, file, window}, stream);
    demand(per_100k(free.outcome.cpu, stream) <= 0.3, "0.3 CPU s for 100,000 lines unpaced");
    measure("bare loop", printer(0, false, bytes), {self, "--bare", "PORT", rate, file, window, "0"}, stream);
    std::printf("  %-24s %5.2f CPU s/100k lines\n", "voidpath, in memory",
                per_100k(print_in_memory(file, bytes), stream));
  }
}

int bench_stream(const std::string& self, const std::string& python, const std::vector<std::string>& files,
                 std::size_t lines) {
  const auto scratch =
      std::filesystem::temp_directory_path() / ("bench_stream." + std::to_string(::getpid()));
  std::filesystem::create_directories(scratch);
  if (!take_precedence()) std::printf("without precedence: other programs are measured, too\n");
  std::printf("a thread here pays %.1f us of CPU to sleep 3 ms and do nothing\n", 1e6 * cost_of_sleep_s());
  for (const std::string& file : files) {
    const Stream stream = moves_of(file, lines, scratch);
    for (const double baud : {115200.0, 250000.0}) {
      std::printf("%s: %zu moves at %.0f baud\n", std::filesystem::path(file).filename().c_str(),
                  stream.lines, baud);
      compare(self, python, stream, baud);
    }
  }
  const Stream all = moves_of(files.front(), 1000000, scratch);
  std::printf("%s: %zu moves without a wire\n", std::filesystem::path(files.front()).filename().c_str(),
              all.lines);
  unpaced(self, all);
  std::filesystem::remove_all(scratch);
  return failures == 0 ? 0 : 1;
}

// From the call of halt() to M112 in the terminal, at moments spread over the print.
int bench_estop(const std::string& self, const std::string& file, int trials) {
  const auto scratch = std::filesystem::temp_directory_path() / ("bench_estop." + std::to_string(::getpid()));
  std::filesystem::create_directories(scratch);
  const Stream stream = moves_of(file, 20000, scratch);
  std::vector<double> took_ms;
  for (int i = 0; i < trials; ++i) {
    const double after_s = 0.05 + 0.0037 * (i % 40);
    const Outcome o = run_host(
        printer(250000, false),
        {self, "--stop", "PORT", "250000", stream.file.string(), std::to_string(after_s)}, kFirst, kLast, 60);
    if (o.halted_at_s < 0 || o.exit_code != 0) throw std::runtime_error("a stop did not arrive");
    took_ms.push_back(1000 * (o.halted_at_s - std::atof(o.output.c_str())));
  }
  std::filesystem::remove_all(scratch);
  std::sort(took_ms.begin(), took_ms.end());
  const auto at = [&](double q) {
    return took_ms[std::min(took_ms.size() - 1,
                            static_cast<std::size_t>(q * static_cast<double>(took_ms.size())))];
  };
  std::printf(
      "halt() to M112 in the terminal, %d stops while streaming at 250000: median %.2f ms, p99 %.2f ms, "
      "longest %.2f ms\n",
      trials, at(0.5), at(0.99), took_ms.back());
  demand(at(0.99) <= 5, "p99 within 5 ms");
  return failures == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> a(argv + 1, argv + argc);
  try {
    if (a.size() == 5 && a[0] == "--host")
      return print_file(a[1], std::atoi(a[2].c_str()), true, a[3], std::atoi(a[4].c_str()));
    if (a.size() == 6 && a[0] == "--bare")
      return stream_bare(a[1], std::atoi(a[2].c_str()), a[3], std::atoi(a[4].c_str()), a[5] == "1");
    if (a.size() == 5 && a[0] == "--stop")
      return stop_print(a[1], std::atoi(a[2].c_str()), a[3], std::atof(a[4].c_str()));
    const std::string self = std::filesystem::canonical("/proc/self/exe").string();
    if (a.size() >= 2 && a[0] == "--estop")
      return bench_estop(self, a[1], a.size() > 2 ? std::atoi(a[2].c_str()) : 200);
    if (a.size() >= 3)
      return bench_stream(self, a[0], {a.begin() + 2, a.end()},
                          static_cast<std::size_t>(std::atoi(a[1].c_str())));
    std::fprintf(
        stderr,
        "usage: bench_stream PRINTCORE_HOST.py|- LINES FILE.gcode... | --estop FILE.gcode [TRIALS]\n");
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_stream: %s\n", error.what());
    return 1;
  }
}
