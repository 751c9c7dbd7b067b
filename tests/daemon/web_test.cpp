#include "daemon/event_loop.h"
#include "daemon/systemd_notify.h"
#include "daemon/web/api.h"
#include "tests/daemon/fakes.h"

#include <atomic>
#include <cstdlib>
#include <future>
#include <thread>

#include <catch2/catch.hpp>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

using namespace voidpath::test;
using namespace voidpath::daemon;

namespace {

/// The interface in front of a runner, with a real server and a real client.
struct WebRig {
  RunnerRig rig;
  SnapshotBox box;
  std::atomic<int> halts = 0;
  Api api{rig.loop, *rig.runner, box, [this](const std::string&) { ++halts; },
          [this] { box.put(make_snapshot(*rig.runner, *rig.settler)); }};
  HttpServer server{"127.0.0.1:0", [this](const HttpRequest& r) { return api.handle(r); }, "/api/v1/files",
                    [this](const HttpRequest& r, const auto& receive) { return api.upload(r, receive); }};
  std::string address = "127.0.0.1:" + std::to_string(server.port());
  ~WebRig() { api.close(); }

  HttpResponse ask(const std::function<std::optional<HttpResponse>()>& call) {
    const auto answered = std::make_shared<bool>(false);
    auto answer = std::async(std::launch::async, [&] {
      auto out = call();
      rig.loop.post([answered] { *answered = true; });
      return out;
    });
    rig.loop.run_until([&] { return *answered; });
    return answer.get().value_or(HttpResponse{0, "", ""});
  }
  HttpResponse get(const std::string& path) {
    box.put(make_snapshot(*rig.runner, *rig.settler));
    return ask([&] { return http_call(address, "GET", path); });
  }
  HttpResponse post(const std::string& command, const std::string& body = "{}") {
    return ask([&] { return http_call(address, "POST", "/api/v1/command/" + command, body); });
  }
};

}  // namespace

TEST_CASE("status, queue, history and the page are served") {
  WebRig web;
  web.rig.connect();
  web.rig.drop("a.stl");
  REQUIRE(web.rig.reaches("a.stl", State::waiting_bed));
  const Json status = Json::parse(web.get("/api/v1/status").body);
  const Json& printer = status["printers"].items().at(0);
  CHECK(printer["name"].text() == "left");
  CHECK(printer["connected"].boolean());
  CHECK_FALSE(printer["bed_clear"].boolean(true));
  CHECK(printer["next"]["file"].text() == "a.stl");
  CHECK(printer["waiting"].text().find("bed") != std::string::npos);
  CHECK(Json::parse(web.get("/api/v1/queue").body)["jobs"].items().size() == 1);
  CHECK(Json::parse(web.get("/api/v1/history").body).is_array());
  CHECK(web.get("/api/v1/history.csv").body.rfind("id,file", 0) == 0);
  CHECK(Json::parse(web.get("/api/v1/calibration").body)["corrections"].is_array());
  CHECK(Json::parse(web.get("/api/v1/terminal").body)["lines"].items().size() == 2);
  CHECK(web.get("/").body.find("</html>") != std::string::npos);
  CHECK(web.get("/api/v1/nonsense").status == 404);
}

TEST_CASE("commands reach the runner, and refusals come back in words") {
  WebRig web;
  web.rig.connect();
  web.rig.drop("a.stl");
  REQUIRE(web.rig.reaches("a.stl", State::waiting_bed));
  const auto refused = web.post("pause");
  CHECK(refused.status == 409);
  CHECK(Json::parse(refused.body)["error"].text().find("nothing is being printed") != std::string::npos);
  CHECK(web.post("bed-clear").status == 200);
  // Whoever asks right after a command sees what came of it.
  CHECK(web.box.get()->status["printers"].items().at(0)["state"].text() == "heating");
  REQUIRE(web.rig.reaches("a.stl", State::heating));
  CHECK(web.post("cancel", "{\"job\":99}").status == 409);
  CHECK(web.post("cancel", "{broken").status == 400);
  CHECK(web.post("no-such").status == 409);
  CHECK(web.post("stop").status == 200);
  CHECK(web.halts == 1);
  CHECK(web.rig.store->history().at(0).state == "failed");
}

TEST_CASE("a web page elsewhere cannot command: the header is demanded") {
  WebRig web;
  HttpRequest request;
  request.method = "POST";
  request.path = "/api/v1/command/stop";
  CHECK(web.api.handle(request).status == 403);
  CHECK(web.halts == 0);
}

TEST_CASE("an upload becomes a job in the printer's folder, with its options") {
  WebRig web;
  const std::string bytes = "solid x\n" + std::string(300'000, ' ') + "\nendsolid x\n";
  const auto file = web.rig.dir.write("b c.stl", bytes);
  const auto answer = web.ask([&] {
    return http_upload(web.address,
                       "/api/v1/files?name=" + url_escape("b c.stl") + "&copies=2&method=as-delivered",
                       file.string());
  });
  REQUIRE(answer.status == 201);
  REQUIRE(web.rig.runner->queue().size() == 1);
  const Job& job = *web.rig.runner->queue()[0];
  CHECK(job.id == Json::parse(answer.body)["job"].integer());
  CHECK(job.options.copies == 2);
  CHECK(job.options.method == "as-delivered");
  CHECK(read_all(web.rig.dir / "inbox/b c.stl") == bytes);
  // The same name again gets a number; a foreign kind is refused; nothing is left behind.
  CHECK(web.ask([&] { return http_upload(web.address, "/api/v1/files?name=b%20c.stl", file.string()); })
            .status == 201);
  CHECK(std::filesystem::exists(web.rig.dir / "inbox/b c-2.stl"));
  CHECK(web.ask([&] { return http_upload(web.address, "/api/v1/files?name=x.exe", file.string()); }).status ==
        415);
  for (const std::string wrong :
       {"method=bogus", "copies=0", "copies=1001", "copies=x", "scale=0", "scale=2x"}) {
    INFO(wrong);
    CHECK(
        web.ask([&] { return http_upload(web.address, "/api/v1/files?name=b.stl&" + wrong, file.string()); })
            .status == 400);
  }
  CHECK(web.rig.runner->queue().size() == 2);
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(web.rig.dir / "inbox"))
    files += entry.is_regular_file() ? 1u : 0u;
  CHECK(files == 2);
}

TEST_CASE("power and light are switched on or off, where there are any") {
  WebRig web;
  CHECK(web.post("power", R"({"switch":"maybe"})").body.find("say on or off") != std::string::npos);
  CHECK(web.post("power", R"({"switch":"on"})").body.find("has no relay") != std::string::npos);
  CHECK(web.post("light", R"({"switch":"off"})").status == 409);
}

TEST_CASE("a port in use is an error that names it") {
  WebRig web;
  const auto nothing = [](const HttpRequest&) { return HttpResponse{}; };
  const auto no_upload = [](const HttpRequest&, const auto&) { return HttpResponse{}; };
  CHECK_THROWS_WITH(HttpServer(web.address, nothing, "/x", no_upload), Catch::Contains(web.address));
  CHECK_THROWS_AS(split_address("nowhere"), std::invalid_argument);
  CHECK(split_address("[::1]:80") == std::pair<std::string, int>("::1", 80));
  CHECK_FALSE(http_call("127.0.0.1:1", "GET", "/"));
}

TEST_CASE("the loop runs what is posted, timers in their order, and readers") {
  EventLoop loop;
  std::string order;
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  loop.add_fd(ends[0], [&] {
    char c = 0;
    if (::read(ends[0], &c, 1) == 1) order += c;
    loop.quit();
  });
  loop.after(0.02, [&] {
    order += '3';
    if (::write(ends[1], "4", 1) != 1) order += '!';
  });
  loop.after(0.01, [&] { order += '2'; });
  const auto never = loop.after(0.005, [&] { order += 'x'; });
  loop.cancel(never);
  std::thread other([&] { loop.post([&] { order += '1'; }); });
  other.join();
  loop.run();
  CHECK(order == "1234");
  ::close(ends[0]);
  ::close(ends[1]);
}

TEST_CASE("the service manager hears what it is told") {
  TempDir dir;
  const std::string path = dir / "notify";
  const int socket = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  REQUIRE(::bind(socket, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
  ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
  notify_manager("READY=1\nSTATUS=idle");
  char buffer[64] = {};
  CHECK(::recv(socket, buffer, sizeof buffer, MSG_DONTWAIT) == 19);
  CHECK(std::string(buffer) == "READY=1\nSTATUS=idle");
  ::unsetenv("NOTIFY_SOCKET");
  notify_manager("READY=1");
  CHECK(::recv(socket, buffer, sizeof buffer, MSG_DONTWAIT) < 0);
  ::close(socket);

  CHECK_FALSE(watchdog_period_s());
  ::setenv("WATCHDOG_USEC", "30000000", 1);
  CHECK(watchdog_period_s() == Approx(30));
  ::setenv("WATCHDOG_PID", "1", 1);
  CHECK_FALSE(watchdog_period_s());
  ::unsetenv("WATCHDOG_USEC");
  ::unsetenv("WATCHDOG_PID");
}
