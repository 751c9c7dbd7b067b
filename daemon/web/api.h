#pragma once

#include "daemon/web/http.h"
#include "daemon/web/snapshot.h"

#include <atomic>
#include <filesystem>
#include <functional>

namespace voidpath::daemon {

/// The JSON interface below /api/v1/. Called on HTTP threads: reads snapshots, and has the loop do
/// everything else, waiting for its answer.
///
/// GET  status, queue, history, history.csv, calibration, logs?after=ID, terminal?printer=NAME
/// POST command/NAME with {"job", "printer", "place", "line", "switch"};
/// files?name=NAME&copies=&method=&scale=&printer=
class Api {
 public:
  /// All must outlive it. `halt` is called on the caller's thread, before the loop hears of it; `refresh`
  /// on the loop: it publishes a snapshot.
  Api(Executor& loop, Runner& runner, const SnapshotBox& box,
      std::function<void(const std::string& printer)> halt, std::function<void()> refresh);

  HttpResponse handle(const HttpRequest& request);
  HttpResponse upload(const HttpRequest& request,
                      const std::function<bool(const HttpServer::Sink&)>& receive);
  /// Those who wait for the loop are sent away. Any thread.
  void close() noexcept { closing_ = true; }

 private:
  using Work = std::function<HttpResponse()>;
  /// With `changes`, a fresh snapshot is published before the answer.
  HttpResponse on_loop(Work work, bool changes = false);
  HttpResponse get(const std::string& what, const HttpRequest& request);
  HttpResponse command(const std::string& name, const HttpRequest& request);
  void run_command(const std::string& name, const Json& body);

  Executor& loop_;
  Runner& runner_;
  const SnapshotBox& box_;
  std::function<void(const std::string&)> halt_;
  std::function<void()> refresh_;
  std::atomic<bool> closing_ = false;
};

}  // namespace voidpath::daemon
