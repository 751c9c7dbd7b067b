#include "firmware-io/transport/fd_transport.h"
#include "tests/firmware-io/session_rig.h"

#include <cstdlib>

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <unistd.h>

using namespace voidpath::fw;
using namespace voidpath::test;

namespace {

Lines printed(Peer& peer) {
  Lines out = peer.executed();
  std::erase_if(out, [](const std::string& line) {
    return line == "M115" || line == "M503" || line == "M211" || line.starts_with("M113") ||
           line.starts_with("M155") || line.starts_with("M110") || line == "M105";
  });
  return out;
}

}  // namespace

TEST_CASE("a session prints a file over a loopback", "[session]") {
  SessionRig rig;
  REQUIRE(rig.listener.wait_for<Connected>());
  CHECK(rig.listener.last<Connected>().firmware.machine == "Model Machine");
  Lines file = moves(2000);
  rig.port->print(source(file));
  REQUIRE(rig.listener.wait_for<PrintFinished>());
  file.push_back("M400");
  CHECK(printed(rig.peer()) == file);
  CHECK(rig.listener.count<LineDone>() == 2000);
  const auto dialogue = rig.port->dialogue();
  REQUIRE(dialogue.size() > 300);
  CHECK(dialogue.back().find("< ok") != std::string::npos);
}

TEST_CASE("a pulled cable fails the print, and the port comes back by itself", "[session]") {
  SessionRig rig;
  REQUIRE(rig.print_to_hold());
  rig.unplug();
  REQUIRE(rig.listener.wait_for<PrintFailed>());
  REQUIRE(rig.listener.wait_for<Disconnected>());
  CHECK(rig.listener.last<PrintFailed>().reason.find("connection lost") == 0);
  REQUIRE(rig.listener.wait_for<Disconnected>(2));  // now because it cannot be opened
  CHECK(rig.listener.last<Disconnected>().reason == "test port: unplugged");
  rig.plug();
  REQUIRE(rig.listener.wait_for<Connected>(2));
  rig.port->print(source(moves(5)));
  REQUIRE(rig.listener.wait_for<PrintFinished>());
}

TEST_CASE("a printer reset in mid-print is printed on by nobody", "[session]") {
  SessionRig rig;
  REQUIRE(rig.print_to_hold());
  rig.peer().reset();
  REQUIRE(rig.listener.wait_for<PrintFailed>());
  REQUIRE(rig.listener.wait_for<Connected>(2));
  CHECK(printed(rig.peer()).size() < 60);
}

TEST_CASE("pause, resume and cancel reach a running print", "[session]") {
  SessionRig rig;
  REQUIRE(rig.print_to_hold());
  rig.port->pause();
  REQUIRE(rig.listener.wait_for<Paused>());
  rig.peer().hold_at(moves(500)[200]);
  rig.port->resume();
  REQUIRE(rig.listener.wait_for<Resumed>());
  REQUIRE(rig.listener.wait_for<LineDone>(200));
  rig.port->cancel("enough");
  rig.peer().hold_at("");
  REQUIRE(rig.listener.wait_for<PrintCancelled>());
  const Lines all = printed(rig.peer());
  const Lines end{"M104 S0", "M140 S0", "M107", "M84"};
  REQUIRE(all.size() > 204);
  CHECK(Lines(all.end() - 4, all.end()) == end);
  CHECK(all.size() < 215);
}

TEST_CASE("destruction ends a running print with the heaters off", "[session]") {
  auto rig = std::make_unique<SessionRig>();
  REQUIRE(rig->listener.wait_for<Connected>());
  rig->port->print(source(moves(100000)));
  REQUIRE(rig->listener.wait_for<LineDone>(50));
  rig->port.reset();
  CHECK(rig->listener.count<PrintCancelled>() == 1);
  const Lines all = printed(rig->peer());
  const Lines end{"M104 S0", "M140 S0", "M107", "M84"};
  REQUIRE(all.size() > 50);
  CHECK(Lines(all.end() - 4, all.end()) == end);
}

TEST_CASE("destruction does not wait long for a printer that hangs", "[session]") {
  marlin::SessionOptions options = quick();
  options.shutdown_s = 0.05;
  SessionRig rig(options);
  REQUIRE(rig.print_to_hold());
  const auto begun = std::chrono::steady_clock::now();
  rig.port.reset();
  CHECK(std::chrono::steady_clock::now() - begun < std::chrono::seconds(5));
}

TEST_CASE("a missing port is reported with its name", "[session]") {
  Listener listener;
  PortOptions options;
  options.port = "/dev/no-such-printer";
  options.reconnect_s = 0.01;
  const auto port = open_marlin(options, steady_clock(), listener.handler());
  REQUIRE(listener.wait_for<Disconnected>());
  CHECK(listener.last<Disconnected>().reason.find("/dev/no-such-printer") != std::string::npos);
  port->print(source(moves(2)));
  REQUIRE(listener.wait_for<PrintFailed>());
}

TEST_CASE("a file goes through a pseudo terminal at a Marlin's odd baud rate", "[session]") {
  const int master = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  REQUIRE(master >= 0);
  REQUIRE(::grantpt(master) == 0);
  REQUIRE(::unlockpt(master) == 0);
  const std::string slave = ::ptsname(master);
  const int keep_open =
      ::open(slave.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);  // else the master hangs up at once
  REQUIRE(keep_open >= 0);
  Peer peer(std::make_unique<FdTransport>(master, "pty master"));
  Listener listener;
  PortOptions options;
  options.port = slave;
  options.baud = 250000;
  options.boot_wait_s = 0.05;
  options.reconnect_s = 0.05;
  const auto port = open_marlin(options, steady_clock(), listener.handler());
  REQUIRE(listener.wait_for<Connected>());
  Lines file = moves(500);
  port->print(source(file));
  REQUIRE(listener.wait_for<PrintFinished>());
  file.push_back("M400");
  CHECK(printed(peer) == file);

  Listener second;
  const auto rival = open_marlin(options, steady_clock(), second.handler());
  REQUIRE(second.wait_for<Disconnected>());
  CHECK(second.last<Disconnected>().reason.find("in use") != std::string::npos);
  ::close(keep_open);
}
