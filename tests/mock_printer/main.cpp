#include "tests/mock_printer/mock_s3g.h"
#include "tests/mock_printer/runner.h"

#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace {

using namespace voidpath::test::mock;

RunnerRequests g_requests;  // signal handlers have no other way to speak

extern "C" void on_signal(int signal) {
  if (signal == SIGUSR1)
    g_requests.report = true;
  else if (signal == SIGUSR2)
    g_requests.reset = true;
  else
    g_requests.stop = true;
}

constexpr const char* kUsage =
    "usage: mock-printer --link PATH [options]\n"
    "  --link PATH           the port, a link to a pty\n"
    "  --speed F             printer seconds a second; 0: as fast as it can (1)\n"
    "  --grace-s F           wall seconds an accelerated clock waits for a silent host (2)\n"
    "  --clock FILE          publish the clock\n"
    "  --log FILE            each executed command\n"
    "  --faults FILE.yaml    what goes wrong\n"
    "  --seed N              of the faults by chance\n"
    "  --firmware NAME       marlin2, marlin1, marlin10, prusa, repetier, smoothie, klipper, s3g\n"
    "  --tools N --heated-bed   of an s3g printer (1, none); give --firmware before its motion's options\n"
    "  --baud N              pace of the wire in the printer's time (no limit)\n"
    "  --latency-ms F        round trip (0)\n"
    "  --rx-buffer N --queue N --block-buffer N   sizes (128, 4, 16)\n"
    "  --boot-s F            deaf so long after a reset (0)\n"
    "  --reset-on-open       each open of the port resets the printer\n"
    "  --advanced-ok --emergency-parser --meatpack --cold-extrusion\n"
    "  --steps, --max-speed, --max-acceleration, --jerk X,Y,Z,E   --acceleration PRINT,RETRACT,TRAVEL\n"
    "  --junction-deviation MM   --volume X,Y,Z (what M211 tells)\n"
    "SIGUSR1: report on stderr; SIGUSR2: reset\n";

struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

template <class T>
T number(std::string_view flag, std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    throw UsageError(std::string(flag) + ": not a number: " + std::string(text));
  return value;
}

template <std::size_t N>
std::array<double, N> numbers(std::string_view flag, std::string_view text) {
  std::array<double, N> values{};
  for (std::size_t i = 0; i < N; ++i) {
    const auto comma = text.find(',');
    if ((comma == text.npos) != (i + 1 == N))
      throw UsageError(std::string(flag) + " wants " + std::to_string(N) + " numbers");
    values[i] = number<double>(flag, text.substr(0, comma));
    if (comma != text.npos) text.remove_prefix(comma + 1);
  }
  return values;
}

struct Setup {
  Options printer;
  bool s3g = false;
  int tools = 1;
  bool heated_bed = false;
  RunnerOptions runner;
};

bool take_switch(Setup& s, std::string_view flag) {
  if (flag == "--advanced-ok") return s.printer.advanced_ok = true;
  if (flag == "--emergency-parser") return s.printer.emergency_parser = true;
  if (flag == "--meatpack") return s.printer.meatpack = true;
  if (flag == "--cold-extrusion") return s.printer.cold_extrusion = true;
  if (flag == "--heated-bed") return s.heated_bed = true;
  if (flag == "--reset-on-open") return s.runner.reset_on_open = true;
  return false;
}

bool take_motion(MotionSettings& m, std::string_view flag, std::string_view v) {
  if (flag == "--steps") {
    m.steps_per_mm = numbers<kAxes>(flag, v);
  } else if (flag == "--max-speed") {
    m.max_speed = numbers<kAxes>(flag, v);
  } else if (flag == "--max-acceleration") {
    m.max_acceleration = numbers<kAxes>(flag, v);
  } else if (flag == "--jerk") {
    m.jerk = numbers<kAxes>(flag, v);
    m.classic_jerk = true;
  } else if (flag == "--junction-deviation") {
    m.junction_deviation = number<double>(flag, v);
  } else if (flag == "--acceleration") {
    const auto a = numbers<3>(flag, v);
    m.print_acceleration = a[0];
    m.retract_acceleration = a[1];
    m.travel_acceleration = a[2];
  } else {
    return false;
  }
  return true;
}

bool take_wire(Options& p, std::string_view flag, std::string_view v) {
  if (flag == "--baud")
    p.baud = number<double>(flag, v);
  else if (flag == "--latency-ms")
    p.round_trip_s = number<double>(flag, v) / 1000;
  else if (flag == "--rx-buffer")
    p.rx_buffer = number<std::size_t>(flag, v);
  else if (flag == "--queue")
    p.queue = number<std::size_t>(flag, v);
  else if (flag == "--block-buffer")
    p.block_buffer = number<std::size_t>(flag, v);
  else if (flag == "--boot-s")
    p.boot_s = number<double>(flag, v);
  else
    return false;
  return true;
}

void take_value(Setup& s, std::string_view flag, std::string_view v) {
  if (take_motion(s.printer.motion, flag, v) || take_wire(s.printer, flag, v)) return;
  if (flag == "--link") {
    s.runner.link = v;
  } else if (flag == "--speed") {
    s.runner.speed = number<double>(flag, v);
  } else if (flag == "--grace-s") {
    s.runner.grace_s = number<double>(flag, v);
  } else if (flag == "--clock") {
    s.runner.clock_file = v;
  } else if (flag == "--log") {
    s.runner.log_file = v;
  } else if (flag == "--volume") {
    s.printer.volume_mm = numbers<3>(flag, v);
  } else if (flag == "--faults") {
    s.printer.faults = load_faults(std::string(v));
  } else if (flag == "--seed") {
    s.printer.seed = number<std::uint64_t>(flag, v);
  } else if (flag == "--tools") {
    s.tools = std::clamp(number<int>(flag, v), 1, 2);
  } else if (flag == "--firmware") {
    if (v == "s3g") {
      s.s3g = true;
      s.printer.motion = S3gOptions::replicator_motion();
      return;
    }
    const auto dialect = find_dialect(v);
    if (!dialect) throw UsageError("--firmware: unknown: " + std::string(v));
    s.printer.dialect = *dialect;
  } else {
    throw UsageError("unknown option " + std::string(flag));
  }
}

Setup parse(int argc, char** argv) {
  Setup setup;
  for (int i = 1; i < argc; ++i) {
    std::string_view flag = argv[i];
    if (take_switch(setup, flag)) continue;
    if (const auto equals = flag.find('='); equals != flag.npos) {
      take_value(setup, flag.substr(0, equals), flag.substr(equals + 1));
      continue;
    }
    if (i + 1 >= argc) throw UsageError("option without value or unknown: " + std::string(flag));
    take_value(setup, flag, argv[++i]);
  }
  if (setup.runner.link.empty()) throw UsageError("--link is missing");
  if (setup.runner.speed < 0) throw UsageError("--speed is 0 or more");
  if (setup.printer.block_buffer < 4 || setup.printer.queue < 1 || setup.printer.rx_buffer < 2)
    throw UsageError("a buffer is too small");
  return setup;
}

std::unique_ptr<Firmware> build(const Setup& setup) {
  const Options& p = setup.printer;
  if (!setup.s3g) return std::make_unique<MockMarlin>(p);
  S3gOptions o;
  o.motion = p.motion;
  o.block_buffer = p.block_buffer;
  o.tools = setup.tools;
  o.heated_bed = setup.heated_bed;
  o.baud = p.baud;
  o.round_trip_s = p.round_trip_s;
  o.boot_s = p.boot_s;
  o.hotend = p.hotend;
  o.bed = p.bed;
  o.faults = p.faults;
  o.seed = p.seed;
  return std::make_unique<MockS3g>(o);
}

void catch_signals() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  for (const int signal : {SIGUSR1, SIGUSR2, SIGTERM, SIGINT, SIGHUP}) ::sigaction(signal, &action, nullptr);
  ::signal(SIGPIPE, SIG_IGN);
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i)
    if (std::strcmp(argv[i], "--help") == 0) return std::fputs(kUsage, stdout) < 0;
  try {
    const Setup setup = parse(argc, argv);
    catch_signals();
    Runner runner(build(setup), setup.runner);
    std::printf("ready %s\n", setup.runner.link.c_str());
    std::fflush(stdout);
    runner.run(g_requests);
    std::fprintf(stderr, "%s\n", to_json(runner.printer().statistics()).c_str());
    return 0;
  } catch (const UsageError& e) {
    std::fprintf(stderr, "mock-printer: %s\n%s", e.what(), kUsage);
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "mock-printer: %s\n", e.what());
    return 1;
  }
}
