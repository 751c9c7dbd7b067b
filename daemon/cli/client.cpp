#include "daemon/cli/client.h"

#include "config/config.h"
#include "daemon/jobs/job_options.h"
#include "daemon/web/http.h"

#include <charconv>
#include <filesystem>

namespace voidpath::cli {
namespace {

using daemon::HttpResponse;
using daemon::Json;

template <typename Read>
auto option(const std::string& flag, const std::string& text, Read&& read) {
  try {
    return read(text);
  } catch (const std::invalid_argument& wrong) {
    throw ClientError(kUsage, flag + ": " + wrong.what());
  }
}

std::string address_from(const ClientFlags& flags) {
  if (!flags.host.empty()) return flags.host;
  const std::filesystem::path file =
      flags.config.empty() ? config::default_config_file() : std::filesystem::path(flags.config);
  if (file.empty()) return config::DaemonConfig{}.listen;
  try {
    return config::load_daemon(file).listen;
  } catch (const config::ConfigError& error) {
    throw ClientError(kUsage, error.what());
  }
}

std::string body_of(const std::optional<HttpResponse>& answer, const std::string& address) {
  if (!answer) {
    throw ClientError(kUnreachable, "no daemon answers on " + address +
                                        "; start voidpathd, or name its address with --host or --config");
  }
  if (answer->status < 300) return answer->body;
  std::string why = "the daemon answers " + std::to_string(answer->status);
  try {
    why = Json::parse(answer->body)["error"].text(why);
  } catch (const daemon::JsonError&) {
    // Not ours: the status has to do.
  }
  const int code = answer->status == 415 ? kRefused : answer->status == 503 ? kUnreachable : kFailed;
  throw ClientError(code, why);
}

Json parsed(const std::string& body, const std::string& address) {
  try {
    return Json::parse(body);
  } catch (const daemon::JsonError& error) {
    throw ClientError(kFailed, address + " is no voidpathd: " + error.what());
  }
}

}  // namespace

ClientFlags parse_client(const std::string& command, const std::vector<std::string>& args) {
  ClientFlags flags;
  for (std::size_t i = 0; i < args.size(); ++i) {
    const std::string& arg = args[i];
    const auto value = [&]() -> const std::string& {
      if (i + 1 >= args.size()) throw ClientError(kUsage, command + ": " + arg + " wants a value");
      return args[++i];
    };
    if (arg == "--config")
      flags.config = value();
    else if (arg == "--host")
      flags.host = value();
    else if (arg == "--printer")
      flags.printer = value();
    else if (arg == "--json")
      flags.json = true;
    else if (arg == "--csv" && command == "history")
      flags.csv = true;
    else if ((arg == "-f" || arg == "--follow") && (command == "logs" || command == "watch"))
      flags.follow = true;
    else if (arg == "--as-delivered" && command == "add")
      flags.as_delivered = true;
    else if (arg == "--method" && command == "add")
      flags.method = option(arg, value(), daemon::read_method);
    else if (arg == "--slicer" && command == "add")
      flags.slicer = option(arg, value(), daemon::read_slicer);
    else if (arg == "--copies" && command == "add")
      flags.copies = option(arg, value(), daemon::read_copies);
    else if (arg == "--scale" && command == "add")
      flags.scale = option(arg, value(), daemon::read_scale);
    else if (arg.size() > 1 && arg[0] == '-')
      throw ClientError(kUsage, command + ": do not know " + arg);
    else
      flags.rest.push_back(arg);
  }
  return flags;
}

std::int64_t parse_job(const std::string& text) {
  std::int64_t value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size() || value <= 0) {
    throw ClientError(kUsage, "JOB wants a number above 0, not \"" + text + "\"");
  }
  return value;
}

DaemonClient::DaemonClient(const ClientFlags& flags) : address_(address_from(flags)) {
  try {
    daemon::split_address(address_);
  } catch (const std::invalid_argument& error) {
    throw ClientError(kUsage, error.what());
  }
}

std::string DaemonClient::get_text(const std::string& what) const {
  return body_of(daemon::http_call(address_, "GET", "/api/v1/" + what, {}, 30), address_);
}

Json DaemonClient::get(const std::string& what) const { return parsed(get_text(what), address_); }

Json DaemonClient::command(const std::string& name, const Json& body) const {
  const auto answer = daemon::http_call(address_, "POST", "/api/v1/command/" + name, body.dump(), 30);
  return parsed(body_of(answer, address_), address_);
}

Json DaemonClient::upload(const std::string& file, const ClientFlags& flags) const {
  using daemon::url_escape;
  std::string path = "/api/v1/files?name=" + url_escape(std::filesystem::path(file).filename().string());
  const std::string method = flags.as_delivered ? "as-delivered" : flags.method;
  if (!method.empty()) path += "&method=" + url_escape(method);
  if (!flags.slicer.empty()) path += "&slicer=" + url_escape(flags.slicer);
  if (flags.copies > 0) path += "&copies=" + std::to_string(flags.copies);
  if (flags.scale > 0) path += "&scale=" + daemon::number_text(flags.scale);
  if (!flags.printer.empty()) path += "&printer=" + url_escape(flags.printer);
  return parsed(body_of(daemon::http_upload(address_, path, file), address_), address_);
}

}  // namespace voidpath::cli
