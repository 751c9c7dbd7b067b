#include "daemon/cli/client.h"
#include "daemon/intake/file_checks.h"
#include "daemon/web/http.h"

#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <thread>

namespace voidpath::cli {
namespace {

using daemon::Json;

/// How often logs and the terminal look for news.
constexpr std::chrono::milliseconds kPoll{500};

void print_json(const Json& json) { std::printf("%s\n", json.dump(2).c_str()); }

/// Commands that name a job, a printer, or nothing, and whose answer is "done".
struct Plain {
  const char* name;
  int least;  ///< arguments
  int most;
  const char* arguments;
};
constexpr std::array<Plain, 10> kPlain = {{{"pause", 0, 0, ""},
                                           {"resume", 0, 0, ""},
                                           {"cancel", 0, 1, "[JOB]"},
                                           {"stop", 0, 0, ""},
                                           {"bed-clear", 0, 0, ""},
                                           {"remove", 1, 1, "JOB"},
                                           {"move", 2, 2, "JOB POS"},
                                           {"retry", 1, 1, "JOB"},
                                           {"resume-interrupted", 1, 1, "JOB"},
                                           {"discard", 1, 1, "JOB"}}};
constexpr std::array<const char*, 2> kSwitches = {"power", "light"};
constexpr std::array<const char*, 8> kOthers = {"status",      "add",  "queue",    "history",
                                                "calibration", "logs", "terminal", "watch"};

int plain_command(const Plain& plain, const DaemonClient& client, const ClientFlags& flags) {
  const int count = static_cast<int>(flags.rest.size());
  if (count < plain.least || count > plain.most) {
    throw ClientError(kUsage, std::string("usage: voidpath ") + plain.name + " " + plain.arguments);
  }
  Json body = Json::object();
  if (!flags.printer.empty()) body.set("printer", flags.printer);
  if (count > 0) body.set("job", parse_job(flags.rest[0]));
  if (count > 1) body.set("place", parse_job(flags.rest[1]));
  const Json answer = client.command(plain.name, body);
  if (flags.json) print_json(answer);
  return 0;
}

int switch_command(const char* name, const DaemonClient& client, const ClientFlags& flags) {
  if (flags.rest.size() != 1 || (flags.rest[0] != "on" && flags.rest[0] != "off"))
    throw ClientError(kUsage, std::string("usage: voidpath ") + name + " on|off");
  Json body = Json::object().set("switch", flags.rest[0]);
  if (!flags.printer.empty()) body.set("printer", flags.printer);
  const Json answer = client.command(name, body);
  if (flags.json) print_json(answer);
  return 0;
}

int add_command(const DaemonClient& client, const ClientFlags& flags) {
  if (flags.rest.empty())
    throw ClientError(kUsage, "usage: voidpath add FILE... [--as-delivered] [--copies N]");
  for (const auto& file : flags.rest) {
    if (!std::filesystem::is_regular_file(file)) throw ClientError(kRefused, file + " is no file");
    if (daemon::input_kind(file) == daemon::InputKind::none) {
      throw ClientError(kRefused,
                        file + " is neither a model (.stl .obj .3mf) nor G-code (.gcode .gco .g .gx)");
    }
  }
  Json added = Json::array();
  for (const auto& file : flags.rest) {
    const Json answer = client.upload(file, flags);
    if (!flags.json) {
      std::printf("%s is job %lld\n", file.c_str(), static_cast<long long>(answer["job"].integer()));
    }
    added.push(answer);
  }
  if (flags.json) print_json(Json::object().set("added", std::move(added)));
  return 0;
}

int history_command(const DaemonClient& client, const ClientFlags& flags) {
  if (flags.csv) {
    std::fputs(client.get_text("history.csv").c_str(), stdout);
  } else if (flags.json) {
    print_json(client.get("history"));
  } else {
    print_history(client.get("history"));
  }
  return 0;
}

int other_command(const std::string& command, const DaemonClient& client, const ClientFlags& flags) {
  if (command == "add") return add_command(client, flags);
  if (!flags.rest.empty()) throw ClientError(kUsage, command + " takes no arguments");
  if (command == "history") return history_command(client, flags);
  if (command == "logs") return logs_command(client, flags);
  if (command == "watch") return watch_command(client, flags);
  if (command == "terminal") return terminal_command(client, flags);
  const Json answer = client.get(command);
  if (flags.json) {
    print_json(answer);
  } else if (command == "status") {
    print_status(answer);
  } else if (command == "queue") {
    print_queue(answer);
  } else {
    print_calibration(answer);
  }
  return 0;
}

/// What is new in `now`, given that the printer's record only ever moves on.
std::size_t first_new(const Json::Array& before, const Json::Array& now) {
  for (std::size_t shift = 0; shift < before.size(); ++shift) {
    const std::size_t common = before.size() - shift;
    bool same = common <= now.size();
    for (std::size_t i = 0; same && i < common; ++i) same = before[shift + i].text() == now[i].text();
    if (same) return common;
  }
  return 0;
}

}  // namespace

bool is_client(const std::string& command) {
  for (const auto& plain : kPlain) {
    if (command == plain.name) return true;
  }
  for (const char* name : kSwitches) {
    if (command == name) return true;
  }
  for (const char* name : kOthers) {
    if (command == name) return true;
  }
  return false;
}

int run_client(const std::string& command, const std::vector<std::string>& args) {
  try {
    const ClientFlags flags = parse_client(command, args);
    const DaemonClient client(flags);
    for (const auto& plain : kPlain) {
      if (command == plain.name) return plain_command(plain, client, flags);
    }
    for (const char* name : kSwitches) {
      if (command == name) return switch_command(name, client, flags);
    }
    return other_command(command, client, flags);
  } catch (const ClientError& error) {
    std::fprintf(stderr, "voidpath: %s\n", error.what());
    return error.code();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "voidpath: %s\n", error.what());
    return kFailed;
  }
}

int logs_command(const DaemonClient& client, const ClientFlags& flags) {
  std::int64_t last = 0;
  for (;;) {
    const Json answer = client.get("logs?after=" + std::to_string(last));
    for (const auto& event : answer["events"].items()) {
      last = event["id"].integer();
      if (flags.json) {
        std::printf("%s\n", event.dump().c_str());
      } else {
        std::printf("%s %-7s %s\n", event["at"].text().c_str(), event["level"].text().c_str(),
                    event["text"].text().c_str());
      }
    }
    std::fflush(stdout);
    if (!flags.follow) return 0;
    std::this_thread::sleep_for(kPoll);
  }
}

int terminal_command(const DaemonClient& client, const ClientFlags& flags) {
  const std::string what =
      "terminal" + (flags.printer.empty() ? std::string() : "?printer=" + daemon::url_escape(flags.printer));
  Json::Array seen;
  const auto show = [&] {
    const Json answer = client.get(what);
    const auto& lines = answer["lines"].items();
    for (std::size_t i = first_new(seen, lines); i < lines.size(); ++i)
      std::printf("%s\n", lines[i].text().c_str());
    std::fflush(stdout);
    seen = lines;
  };
  show();
  std::jthread watcher([&](std::stop_token stop) {
    try {
      while (!stop.stop_requested()) {
        std::this_thread::sleep_for(kPoll);
        show();
      }
    } catch (const std::exception&) {
      // The next line the user sends meets the same trouble, and tells.
    }
  });
  const DaemonClient sender(flags);
  for (std::string line; std::getline(std::cin, line);) {
    if (line.empty()) continue;
    Json body = Json::object().set("line", line);
    if (!flags.printer.empty()) body.set("printer", flags.printer);
    sender.command("terminal", body);
  }
  std::this_thread::sleep_for(2 * kPoll);  // for the answer to the last line
  return 0;
}

}  // namespace voidpath::cli
