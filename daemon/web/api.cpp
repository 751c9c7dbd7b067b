#include "daemon/web/api.h"

#include "daemon/intake/file_checks.h"
#include "daemon/jobs/filing.h"
#include "daemon/jobs/job_options.h"
#include "daemon/web/page.h"

#include <cerrno>
#include <charconv>
#include <chrono>
#include <future>
#include <optional>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace voidpath::daemon {
namespace {

/// How long the loop may take to answer, s. It never does long work itself.
constexpr int kPatience_s = 20;
constexpr int kLogLines = 1000;

HttpResponse error(int status, const std::string& text) {
  return {status, Json::object().set("error", text).dump() + "\n", "application/json"};
}

HttpResponse ok(const Json& body) { return {200, body.dump() + "\n", "application/json"}; }

std::int64_t integer(const std::string& text, std::int64_t otherwise) {
  std::int64_t value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  return read.ec == std::errc() && read.ptr == text.data() + text.size() ? value : otherwise;
}

Json learned_json(const LearnedFactor& one) {
  Json out = Json::object();
  out.set("printer", one.printer)
      .set("firmware", one.firmware)
      .set("profile_sha256", one.profile_sha256)
      .set("observations", one.observations)
      .set("needed", calibrate::kMinObservations)
      .set("factor", one.correction ? Json(one.correction->factor) : Json())
      .set("used", one.correction ? Json(one.correction->used) : Json(0))
      .set("rejected", one.correction ? Json(one.correction->rejected) : Json(0))
      .set("spread", one.correction ? Json(one.correction->spread) : Json());
  return out;
}

JobId job_in(const Json& body) {
  if (!body["job"].is_number()) throw CommandError("say which job");
  return body["job"].integer();
}

bool switch_in(const Json& body) {
  const std::string to = body["switch"].text();
  if (to != "on" && to != "off") throw CommandError("say on or off");
  return to == "on";
}

/// Throws std::invalid_argument.
JobOptions options_in(const HttpRequest& request) {
  JobOptions out;
  if (const auto method = request.query_or("method"); !method.empty()) out.method = read_method(method);
  if (const auto slicer = request.query_or("slicer"); !slicer.empty()) out.slicer = read_slicer(slicer);
  if (const auto copies = request.query_or("copies"); !copies.empty()) out.copies = read_copies(copies);
  if (const auto scale = request.query_or("scale"); !scale.empty()) out.scale = read_scale(scale);
  return out;
}

/// A file being uploaded: hidden until it is complete, removed unless it is taken over.
class Incoming {
 public:
  explicit Incoming(const std::filesystem::path& folder)
      : path_((folder / (std::string(kUploadPrefix) + "XXXXXX")).string()),
        fd_(::mkostemp(path_.data(), O_CLOEXEC)) {
    if (fd_ < 0) {
      throw CommandError("cannot write into " + folder.string() + ": " +
                         std::generic_category().message(errno));
    }
    ::fchmod(fd_, 0644);
  }
  ~Incoming() {
    if (fd_ >= 0) ::close(fd_);
    ::unlink(path_.c_str());  // fails harmlessly once it was renamed
  }
  Incoming(const Incoming&) = delete;
  Incoming& operator=(const Incoming&) = delete;

  bool write(const char* data, std::size_t size) {
    while (size > 0) {
      const ssize_t written = ::write(fd_, data, size);
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) {
        why_ = std::generic_category().message(errno);
        return false;
      }
      data += written;
      size -= static_cast<std::size_t>(written);
    }
    return true;
  }
  bool finish() {
    const bool synced = ::fsync(fd_) == 0 && ::close(fd_) == 0;
    fd_ = -1;
    return synced;
  }
  const std::string& path() const noexcept { return path_; }
  const std::string& why() const noexcept { return why_; }

 private:
  std::string path_;
  int fd_;
  std::string why_ = "the connection broke off";
};

}  // namespace

Api::Api(Executor& loop, Runner& runner, const SnapshotBox& box,
         std::function<void(const std::string& printer)> halt, std::function<void()> refresh)
    : loop_(loop), runner_(runner), box_(box), halt_(std::move(halt)), refresh_(std::move(refresh)) {}

HttpResponse Api::on_loop(Work work, bool changes) {
  auto promise = std::make_shared<std::promise<HttpResponse>>();
  auto answer = promise->get_future();
  loop_.post([this, promise, changes, work = std::move(work)] {
    HttpResponse response;
    try {
      response = work();
    } catch (const CommandError& refused) {
      response = error(409, refused.what());
    } catch (const std::exception& failed) {
      response = error(500, failed.what());
    }
    if (!changes) {
      promise->set_value(std::move(response));
      return;
    }
    // Behind what the command itself posted, so that whoever asks next sees what came of it.
    loop_.post([this, promise, response = std::move(response)]() mutable {
      refresh_();
      promise->set_value(std::move(response));
    });
  });
  for (int tenths = 0; tenths < kPatience_s * 10 && !closing_; ++tenths) {
    if (answer.wait_for(std::chrono::milliseconds(100)) == std::future_status::ready) return answer.get();
  }
  return error(503, closing_ ? "the daemon is ending" : "the daemon is busy; try again");
}

HttpResponse Api::handle(const HttpRequest& request) {
  static const std::string kRoot = "/api/v1/";
  static const std::string kCommand = "command/";
  if (request.method == "GET" && (request.path == "/" || request.path == "/index.html")) {
    return {200, kStatusPage, "text/html; charset=utf-8"};
  }
  if (!request.path.starts_with(kRoot)) return error(404, "nothing here; see /api/v1/status");
  const std::string what = request.path.substr(kRoot.size());
  if (request.method == "GET") return get(what, request);
  if (!request.trusted) return error(403, "send the header X-Voidpath: 1");
  if (what.starts_with(kCommand)) return command(what.substr(kCommand.size()), request);
  return error(404, "no such resource: " + what);
}

HttpResponse Api::get(const std::string& what, const HttpRequest& request) {
  if (what == "status") return ok(box_.get()->status);
  if (what == "queue") return ok(box_.get()->queue);
  if (what == "history") {
    return on_loop([this] {
      Json rows = Json::array();
      for (const auto& record : runner_.store().history()) rows.push(history_json(record));
      return ok(rows);
    });
  }
  if (what == "history.csv") {
    return on_loop([this] {
      std::string text = history_csv_header() + "\n";
      for (const auto& record : runner_.store().history()) text += history_csv(record) + "\n";
      return HttpResponse{200, text, "text/csv; charset=utf-8"};
    });
  }
  if (what == "calibration") {
    return on_loop([this] {
      Json rows = Json::array();
      for (const auto& one : runner_.store().learned()) rows.push(learned_json(one));
      return ok(Json::object().set("corrections", std::move(rows)));
    });
  }
  if (what == "logs") {
    const auto after = integer(request.query_or("after"), 0);
    const auto limit =
        static_cast<int>(std::clamp<std::int64_t>(integer(request.query_or("limit"), 200), 1, kLogLines));
    return on_loop([this, after, limit] {
      Json rows = Json::array();
      for (const auto& event : runner_.store().events(after, limit)) {
        rows.push(Json::object()
                      .set("id", event.id)
                      .set("at", event.at)
                      .set("level", event.level)
                      .set("text", event.text));
      }
      return ok(Json::object().set("events", std::move(rows)));
    });
  }
  if (what == "terminal") {
    return on_loop([this, name = request.query_or("printer")] {
      Json lines = Json::array();
      for (const auto& line : runner_.printer(name).dialogue()) lines.push(line);
      return ok(Json::object().set("lines", std::move(lines)));
    });
  }
  return error(404, "no such resource: " + what);
}

void Api::run_command(const std::string& name, const Json& body) {
  const std::string printer = body["printer"].text();
  if (name == "pause") return runner_.pause(printer);
  if (name == "resume") return runner_.resume(printer);
  if (name == "bed-clear") return runner_.bed_clear(printer);
  if (name == "cancel" || name == "remove") {
    std::optional<JobId> job;
    if (name == "remove" || body["job"].is_number()) job = job_in(body);
    return runner_.cancel(job, printer);
  }
  if (name == "retry") return runner_.retry(job_in(body));
  if (name == "resume-interrupted") return runner_.resume_interrupted(job_in(body));
  if (name == "discard") return runner_.discard(job_in(body));
  if (name == "move") return runner_.move(job_in(body), body["place"].integer(1));
  if (name == "power") return runner_.power(printer, switch_in(body));
  if (name == "light") return runner_.light(printer, switch_in(body));
  if (name == "terminal") return runner_.command_line(printer, body["line"].text());
  throw CommandError("there is no command " + name);
}

HttpResponse Api::command(const std::string& name, const HttpRequest& request) {
  Json body;
  try {
    if (!request.body.empty()) body = Json::parse(request.body);
  } catch (const JsonError& broken) {
    return error(400, broken.what());
  }
  if (name == "stop") {
    const std::string printer = body["printer"].text();
    halt_(printer);  // first, and past the loop
    return on_loop(
        [this, printer] {
          runner_.halted(printer, "emergency stop");
          return ok(Json::object().set("done", true));
        },
        true);
  }
  return on_loop(
      [this, name, body] {
        run_command(name, body);
        return ok(Json::object().set("done", true));
      },
      true);
}

HttpResponse Api::upload(const HttpRequest& request,
                         const std::function<bool(const HttpServer::Sink&)>& receive) {
  if (!request.trusted) return error(403, "send the header X-Voidpath: 1");
  const std::string name = std::filesystem::path(request.query_or("name")).filename().string();
  if (input_kind(name) == InputKind::none) {
    return error(415, "\"" + name + "\" is neither a model (.stl .obj .3mf) nor G-code (.gcode .gco .g .gx)");
  }
  JobOptions options;
  try {
    options = options_in(request);
  } catch (const std::invalid_argument& wrong) {
    return error(400, wrong.what());
  }
  const std::string printer = request.query_or("printer");
  try {
    const auto asked = on_loop([this, printer] {
      const auto& watch = runner_.printer(printer).config().watch;
      if (watch.empty()) throw CommandError("the printer has no watched folder to put the file in");
      return ok(Json::object().set("folder", watch.front().string()));
    });
    if (asked.status != 200) return asked;
    const std::filesystem::path folder = Json::parse(asked.body)["folder"].text();
    auto file = std::make_shared<Incoming>(folder);
    if (!receive([&](const char* data, std::size_t size) { return file->write(data, size); }) ||
        !file->finish()) {
      return error(507, "the upload of " + name + " failed: " + file->why());
    }
    return on_loop(
        [this, file, name, options, printer] {
          const JobId id = runner_.add(file->path(), name, options, printer);
          return HttpResponse{201, Json::object().set("job", id).set("file", name).dump() + "\n",
                              "application/json"};
        },
        true);
  } catch (const std::exception& failed) {
    return error(500, failed.what());
  }
}

}  // namespace voidpath::daemon
