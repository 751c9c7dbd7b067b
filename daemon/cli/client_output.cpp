#include "daemon/cli/client.h"
#include "daemon/cli/offline.h"

#include <cmath>
#include <cstdio>
#include <string>

namespace voidpath::cli {
namespace {

using daemon::Json;

std::string span(const Json& seconds) { return seconds.is_number() ? duration_text(seconds.number()) : "-"; }

void print_job(const char* label, const Json& job) {
  if (!job.is_object()) return;
  std::printf("  %s job %lld, %s: %s", label, static_cast<long long>(job["id"].integer()),
              job["file"].text().c_str(), job["state"].text().c_str());
  if (job["copies"].integer(1) > 1) {
    std::printf(" (copy %lld of %lld)", static_cast<long long>(job["copies_done"].integer() + 1),
                static_cast<long long>(job["copies"].integer()));
  }
  std::printf("\n");
}

// What the wire did to the print; empty where nothing is worth telling.
std::string link_text(std::int64_t resends, std::int64_t doubts) {
  std::string out;
  if (resends > 0) out = std::to_string(resends) + " resends";
  if (doubts > 0)
    out += std::string(out.empty() ? "" : ", ") +
           "signs that a damaged line was obeyed: " + std::to_string(doubts);
  return out;
}

}  // namespace

void print_status(const Json& status) {
  for (const auto& printer : status["printers"].items()) {
    std::printf("%s: %s", printer["name"].text().c_str(), printer["state"].text().c_str());
    if (const auto why = printer["offline_reason"].text(); !printer["connected"].boolean() && !why.empty()) {
      std::printf(" (%s)", why.c_str());
    } else if (const auto firmware = printer["firmware"].text(); !firmware.empty()) {
      std::printf(" (%s)", firmware.c_str());
    }
    std::printf("\n");
    for (const auto& [sensor, value] : printer["temperatures"].members()) {
      std::printf("  %s %.1f/%.0f °C\n", sensor.c_str(), value["actual_c"].number(),
                  value["target_c"].number());
    }
    for (const auto& one : printer["limits_differ"].items())
      std::printf("  profile: %s\n", one.text().c_str());
    print_job("now:", printer["job"]);
    if (printer["progress"].is_number()) {
      std::printf("  %.0f %%, layer %lld of %lld, %s printed, %s left\n", printer["progress"].number() * 100,
                  static_cast<long long>(printer["layer"].integer()),
                  static_cast<long long>(printer["job"]["layers"].integer()),
                  span(printer["elapsed_s"]).c_str(), span(printer["left_s"]).c_str());
    }
    if (const auto link = link_text(printer["resends"].integer(), printer["doubts"].integer()); !link.empty())
      std::printf("  link: %s\n", link.c_str());
    if (const auto message = printer["job"]["message"].text(); !message.empty())
      std::printf("  %s\n", message.c_str());
    print_job("next:", printer["next"]);
    std::string pins;
    for (const auto& [name, state] : printer["pins"].members())
      pins += (pins.empty() ? "  " : ", ") + name + ": " + state.text();
    if (!pins.empty()) std::printf("%s\n", pins.c_str());
    if (const auto waiting = printer["waiting"].text(); !waiting.empty())
      std::printf("  waits: %s\n", waiting.c_str());
  }
  if (const auto& worker = status["preparing"]; worker.is_object()) {
    std::printf("preparing job %lld: %s %.0f %%\n", static_cast<long long>(worker["job"].integer()),
                worker["phase"].text().c_str(), worker["fraction"].number() * 100);
  }
  for (const auto& file : status["arriving"].items()) std::printf("arriving: %s\n", file.text().c_str());
}

void print_queue(const Json& queue) {
  for (const auto& job : queue["jobs"].items()) {
    std::printf("%5lld  %-24s %-30s %10s  %s\n", static_cast<long long>(job["id"].integer()),
                job["state"].text().c_str(), job["file"].text().c_str(), span(job["predicted_s"]).c_str(),
                job["message"].text().c_str());
  }
  if (queue["jobs"].items().empty()) std::printf("the queue is empty\n");
}

void print_history(const Json& history) {
  for (const auto& row : history.items()) {
    std::printf("%5lld  %-20s %-12s %-30s", static_cast<long long>(row["id"].integer()),
                row["started"].text("-").c_str(), row["state"].text().c_str(), row["file"].text().c_str());
    if (row["measured_s"].is_number()) {
      const double predicted = row["predicted_s"].number();
      const double measured = row["measured_s"].number();
      std::printf(" predicted %s, measured %s (%+.2f %%)", span(row["predicted_s"]).c_str(),
                  span(row["measured_s"]).c_str(), measured > 0 ? (predicted / measured - 1) * 100 : 0.0);
    }
    if (const auto link = link_text(0, row["doubts"].integer()); !link.empty())
      std::printf(", %s", link.c_str());
    if (const auto reason = row["reason"].text(); !reason.empty()) std::printf(" %s", reason.c_str());
    std::printf("\n");
  }
  if (history.items().empty()) std::printf("nothing has been printed yet\n");
}

void print_calibration(const Json& calibration) {
  for (const auto& row : calibration["corrections"].items()) {
    std::printf("%s, %s, profile %.12s: ", row["printer"].text().c_str(), row["firmware"].text().c_str(),
                row["profile_sha256"].text().c_str());
    if (row["factor"].is_number()) {
      std::printf("predictions are multiplied by %.4f, from %lld prints (spread %.2f %%)\n",
                  row["factor"].number(), static_cast<long long>(row["used"].integer()),
                  row["spread"].number() * 100);
    } else {
      std::printf("%lld of the %lld prints needed\n", static_cast<long long>(row["observations"].integer()),
                  static_cast<long long>(row["needed"].integer()));
    }
  }
  if (calibration["corrections"].items().empty()) std::printf("nothing has been learned yet\n");
}

}  // namespace voidpath::cli
