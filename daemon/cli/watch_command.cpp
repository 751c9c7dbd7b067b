#include "daemon/cli/client.h"
#include "daemon/cli/offline.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <thread>
#include <utility>

#include <unistd.h>

namespace voidpath::cli {

namespace {

using daemon::Json;

constexpr std::chrono::milliseconds kPoll{250};
constexpr int kBarCells = 30;

std::string bar(double fraction) {
  const int full = static_cast<int>(std::lround(std::fmin(std::fmax(fraction, 0), 1) * kBarCells));
  std::string out = "[";
  for (int i = 0; i < kBarCells; ++i) out += i < full ? '#' : '.';
  return out + "] " + fixed(100 * fraction, 0) + " %";
}

std::string temperatures(const Json& printer) {
  std::string out;
  for (const auto& [sensor, value] : printer["temperatures"].members())
    out += (out.empty() ? "" : ", ") + sensor + " " + fixed(value["actual_c"].number(), 0) + "/" +
           fixed(value["target_c"].number(), 0) + " °C";
  return out;
}

/// What goes on, in a line; empty when nothing does. `kind` is what changes only now and then.
struct Scene {
  std::string kind;
  std::string line;
};

/// `by_tenths`: progress counts as something new at every tenth, for output that cannot be drawn over.
Scene scene_of(const Json& status, bool by_tenths) {
  for (const auto& printer : status["printers"].items()) {
    const Json& job = printer["job"];
    if (!job.is_object()) continue;
    const std::string what = job["file"].text() + ": " + job["state"].text();
    if (printer["progress"].is_number() && job["state"].text() == "printing")
      return {what + (by_tenths ? std::to_string(static_cast<int>(10 * printer["progress"].number())) : ""),
              what + " " + bar(printer["progress"].number()) + ", layer " +
                  std::to_string(printer["layer"].integer()) + " of " +
                  std::to_string(job["layers"].integer()) + ", " + duration_text(printer["left_s"].number()) +
                  " left"};
    return {what, what + ", " + temperatures(printer)};
  }
  if (const Json& worker = status["preparing"]; worker.is_object() && !worker.members().empty())
    return {"preparing " + worker["phase"].text(), "preparing: " + worker["phase"].text() + " " +
                                                       fixed(100 * worker["fraction"].number(), 0) + " %"};
  for (const auto& printer : status["printers"].items()) {
    if (!printer["next"].is_object()) continue;
    const std::string line = printer["next"]["file"].text() + ": " + printer["waiting"].text();
    return {line, line};
  }
  if (!status["arriving"].items().empty())
    return {"arriving", "arriving: " + status["arriving"].items()[0].text()};
  return {};
}

/// Empty while no daemon answers, which is told once: it may be restarted meanwhile.
std::optional<Json> status_if_any(const DaemonClient& client, bool& lost) {
  try {
    Json status = client.get("status");
    lost = false;
    return status;
  } catch (const ClientError& error) {
    if (error.code() != kUnreachable) throw;
    if (!std::exchange(lost, true)) std::fprintf(stderr, "voidpath: %s; waiting for it\n", error.what());
    return std::nullopt;
  }
}

}  // namespace

int watch_command(const DaemonClient& client, const ClientFlags& flags) {
  const bool terminal = ::isatty(STDOUT_FILENO) == 1;
  // Something dropped a moment ago may not have been seen yet.
  constexpr int kPatience = 20;
  int quiet = 0;
  bool seen = false;
  std::string last;
  bool answered = false;
  bool lost = false;
  for (;;) {
    const std::optional<Json> status =
        flags.follow && answered ? status_if_any(client, lost) : std::optional(client.get("status"));
    if (!status) {
      std::this_thread::sleep_for(kPoll);
      continue;
    }
    answered = true;
    const Scene scene = scene_of(*status, !terminal);
    if (flags.json) {
      std::printf("%s\n", status->dump().c_str());
    } else if (terminal && !scene.line.empty()) {
      // A line of its own for every new state; progress is drawn over.
      std::printf("%s\r\033[K%s", !last.empty() && scene.kind != last ? "\n" : "", scene.line.c_str());
    } else if (!scene.line.empty() && scene.kind != last) {
      std::printf("%s\n", scene.line.c_str());
    }
    if (std::fflush(stdout) != 0) return 0;  // nobody reads any more
    last = scene.kind.empty() ? last : scene.kind;
    seen = seen || !scene.line.empty();
    quiet = scene.line.empty() ? quiet + 1 : 0;
    if (!flags.follow && quiet >= (seen ? 2 : kPatience)) break;
    std::this_thread::sleep_for(kPoll);
  }
  if (terminal && seen && !flags.json) std::printf("\n");
  return 0;
}

}  // namespace voidpath::cli
