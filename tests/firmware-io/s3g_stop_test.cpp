#include "firmware-io/s3g/session.h"
#include "firmware-io/transport/loopback.h"
#include "tests/firmware-io/s3g_prints.h"

#include <array>
#include <future>
#include <thread>

#include <catch2/catch.hpp>
#include <poll.h>

using namespace voidpath::fw;
using namespace voidpath::test;

namespace {

/// A MakerBot on a thread of its own, at whose time nothing moves; the first aborts do not reach it.
class HardOfHearing {
 public:
  HardOfHearing(std::unique_ptr<Transport> wire, int aborts_lost)
      : wire_(std::move(wire)), aborts_lost_(aborts_lost) {
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }
  std::uint64_t aborts() {
    thread_.request_stop();
    thread_.join();
    return mock_.aborts();
  }

 private:
  void run(const std::stop_token& stop) {
    const std::string abort = s3g::frame("\x07");
    std::array<char, 4096> buffer;
    while (!stop.stop_requested()) {
      pollfd fd{wire_->fd(), POLLIN, 0};
      ::poll(&fd, 1, 2);
      try {
        while (const auto n = wire_->read(buffer)) {
          std::string bytes(buffer.data(), n);
          if (const auto at = bytes.find(abort); at != std::string::npos && aborts_lost_ > 0) {
            --aborts_lost_;
            bytes.erase(at, abort.size());
          }
          mock_.feed(bytes);
          wire_->write(mock_.take_output());
        }
      } catch (const PortError&) {
        return;  // the host closed its end
      }
    }
  }
  std::unique_ptr<Transport> wire_;
  int aborts_lost_;
  mock::MockS3g mock_;
  std::jthread thread_;
};

}  // namespace

TEST_CASE("a cancel at the panel when all has been sent is no finished print", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  bench.print(kStart + moves(30) + kEnd);
  bench.each_step = [&] {
    const bool sent = bench.count<LineDone>() > 30 && bench.mock.queued_bytes() > 0;
    if (sent && bench.driver.output().empty()) bench.mock.cancel_at_panel();
  };
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  CHECK(bench.count<PrintFinished>() == 0);
  CHECK(bench.count<PrintCancelled>() == 1);
}

TEST_CASE("a cancel at the panel cancels", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  REQUIRE(bench.print_into(kStart + moves(300) + kEnd, 100));
  bench.mock.cancel_at_panel();
  REQUIRE(bench.run_until([&] { return bench.over(); }, 5));
  CHECK(bench.count<PrintCancelled>() == 1);
  CHECK(bench.said("panel"));
  check_next_print(bench);
}

TEST_CASE("a cancel by the user stops at once, cools down, lifts", "[s3g]") {
  const bool inches = GENERATE(false, true);
  s3g::DriverOptions options;
  options.cancel_gcode = {"G91\nG1 Z5 F600", "G90"};
  S3gBench bench(real_wire(), options);
  REQUIRE(bench.connect());
  const Lines file =
      inches ? Lines{"G92 X0 Y0 Z10", "G20"} + Lines(200, "G4 P100") : kStart + moves(300) + kEnd;
  REQUIRE(bench.print_into(file, inches ? 5 : 100));
  const double asked = bench.t;
  bench.driver.cancel("user", bench.t);
  REQUIRE(bench.run_until([&] { return bench.over(); }, 30));
  CHECK(bench.t - asked < 1);
  CHECK(bench.count<PrintCancelled>() == 1);
  bench.run_for(10);
  CHECK(bench.mock.hotend().target() == 0);
  const double z_mm = bench.mock.position()[2] / 400.0;
  CHECK(z_mm == Approx(15).margin(0.1));
  CHECK(bench.mock.violations().empty());
}

TEST_CASE("a move for which there was no room when a cancel came is not sent any more", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  Lines file = kStart;
  for (int i = 0; i < 100; ++i) file.push_back("G1 X" + std::to_string(i % 2 * 60 + i * 0.1) + " E1 F300");
  bench.print(file);
  std::string refused;
  double asked = 0;
  bench.each_step = [&] {
    s3g::PacketReader reader;
    for (const char c : bench.driver.output()) {
      const auto packet = reader.take(c);
      if (!refused.empty() || !packet || bench.mock.queued_bytes() + packet->payload.size() <= 512) continue;
      if (static_cast<unsigned char>(packet->payload[0]) < 128) continue;
      refused = packet->payload;
      asked = bench.t;
      bench.driver.cancel("user", bench.t);
    }
  };
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  REQUIRE_FALSE(refused.empty());
  CHECK(bench.count<PrintCancelled>() == 1);
  CHECK(bench.t - asked < 0.2);
  bench.run_for(60);
  CHECK(std::count(bench.executed.begin(), bench.executed.end(), refused) == 0);
}

TEST_CASE("a command whose fate is open when the print is lost is not sent again", "[s3g]") {
  mock::S3gOptions o = real_wire({{.kind = mock::FaultKind::kDropLine, .at = 30}});
  o.counts_lines = false;
  S3gBench bench(o);
  REQUIRE(bench.connect());
  Lines file = {"G92 X0 Y0 Z0", "M83"};
  for (int i = 1; i < 300; ++i) file.push_back("G1 X" + std::to_string(i % 2 * 30) + " E1 F600");
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.mock.statistics().faults > 0; }));
  bench.run_for(2);
  // Told in reply to a question beside those after the command's fate.
  bool cancelled = false;
  bench.each_step = [&] {
    if (cancelled || bench.driver.output() != s3g::frame(s3g::Payload(s3g::Query::build).bytes())) return;
    cancelled = true;
    bench.mock.cancel_at_panel();
  };
  REQUIRE(bench.run_until([&] { return bench.over(); }, 10));
  CHECK(bench.count<PrintCancelled>() == 1);
  const std::size_t before = bench.executed.size();
  bench.run_for(60);
  CHECK(bench.executed.size() == before);
}

TEST_CASE("a cancel while paused is heard too", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  REQUIRE(bench.print_into(kStart + moves(300) + kEnd, 100));
  bench.driver.pause();
  REQUIRE(bench.run_until([&] { return bench.mock.paused(); }, 5));
  bench.run_for(3);
  bench.driver.cancel("user", bench.t);
  REQUIRE(bench.run_until([&] { return bench.over(); }, 30));
  CHECK(bench.count<PrintCancelled>() == 1);
  bench.run_for(10);
  CHECK(bench.mock.aborts() >= 1);
  CHECK(bench.mock.hotend().target() == 0);
  CHECK_FALSE(bench.driver.closing());
  check_next_print(bench);
}

TEST_CASE("a cancel while paused is said until it is heard, and has failed if it never is", "[s3g]") {
  for (const double silence_s : {0.3, 1e6}) {
    S3gBench bench(real_wire({{.kind = mock::FaultKind::kSilence,
                               .at = 200,
                               .trigger = mock::FaultTrigger::kTime,
                               .seconds = silence_s}}));
    REQUIRE(bench.connect());
    bench.print(kStart + moves(3000) + kEnd);
    bench.run_for(190 - bench.t);
    bench.driver.pause();
    REQUIRE(bench.run_until([&] { return bench.mock.paused(); }, 5));
    bench.run_for(200.01 - bench.t);
    bench.driver.cancel("user", bench.t);
    REQUIRE(bench.run_until([&] { return bench.over(); }, 5));
    if (silence_s < 1) {
      CHECK(bench.count<PrintCancelled>() == 1);
      CHECK(bench.mock.aborts() >= 1);
      CHECK(bench.mock.hotend().target() == 0);
      CHECK_FALSE(bench.driver.closing());
    } else {
      CHECK_THAT(bench.failure(), Catch::Contains("does not hear"));
      CHECK(bench.count<Disconnected>() == 1);
      CHECK(bench.driver.closing());
    }
  }
}

TEST_CASE("the emergency stop goes out at once, and goes around a packet under way", "[s3g]") {
  S3gBench whole(real_wire());
  REQUIRE(whole.connect());
  REQUIRE(whole.print_into(kStart + moves(300), 100));
  const double begun = whole.t;
  // Wherever in an exchange of packets it comes.
  for (int i = 0; i < 40; ++i) {
    S3gBench bench(real_wire());
    REQUIRE(bench.connect());
    bench.print(kStart + moves(300));
    bench.run_for(begun - bench.t);
    const double until = bench.t + i * 0.00017;
    bench.run_for(until - bench.t);
    const double asked = bench.t;
    bench.driver.halt("button", bench.t);
    CHECK(bench.driver.output().ends_with(s3g::frame("\x07")));
    INFO(asked - begun << " s into it");
    REQUIRE(bench.run_until([&] { return bench.mock.aborts() > 0; }, 5));
    CHECK(bench.t - asked < 0.01);
    CHECK(bench.mock.drained());
    REQUIRE(bench.run_until([&] { return bench.driver.closing(); }, 5));
    CHECK(bench.failure() == "button");
    CHECK(bench.driver.finished());
  }
}

TEST_CASE("the emergency stop ends a packet that has begun to leave", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  REQUIRE(bench.print_into(kStart + moves(300), 100));
  REQUIRE(bench.run_until([&] { return bench.driver.output().size() > 20; }));
  const std::string packet = bench.driver.output();
  bench.driver.output().erase(0, 12);
  bench.mock.feed(packet.substr(0, 12));
  const double asked = bench.t;
  bench.driver.halt("button", bench.t);
  CHECK(bench.driver.output() == packet.substr(12) + s3g::frame("\x07"));
  REQUIRE(bench.run_until([&] { return bench.mock.aborts() > 0; }, 5));
  CHECK(bench.t - asked < 0.01);
  // One of which nothing has left stays here.
  S3gBench other(real_wire());
  REQUIRE(other.connect());
  other.print(kStart + moves(300));
  REQUIRE(other.run_until([&] { return other.driver.output().size() > 20; }));
  other.driver.halt("button", other.t);
  CHECK(other.driver.output() == s3g::frame("\x07"));
}

TEST_CASE("the emergency stop is heard when a packet's rest was lost", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  REQUIRE(bench.print_into(kStart + moves(300), 100));
  bench.mock.feed(s3g::frame(std::string(32, 'x')).substr(0, 12));
  const double asked = bench.t;
  bench.driver.halt("button", bench.t);
  REQUIRE(bench.run_until([&] { return bench.mock.aborts() > 0; }, 5));
  CHECK(bench.t - asked < 0.3);
}

TEST_CASE("the emergency stop is said to a printer that still boots until it hears", "[s3g]") {
  mock::S3gOptions booting = real_wire();
  booting.boot_s = GENERATE(5.0, 1e9);
  S3gBench bench(booting);
  bench.driver.halt("button", bench.t);
  REQUIRE(bench.run_until([&] { return bench.driver.closing(); }, 20));
  const bool boots = booting.boot_s < 20;
  CHECK((bench.mock.aborts() > 0) == boots);
  CHECK(bench.driver.halt_heard() == boots);
  bench.driver.opened(bench.t);
  CHECK_FALSE(bench.driver.halt_heard());
}

TEST_CASE("a session does not end before its emergency stop has been heard", "[s3g][session]") {
  Loopback loopback = make_loopback();
  HardOfHearing printer(std::move(loopback.device), 2);
  std::promise<void> connected, printing;
  int lines = 0;
  auto port = s3g::start_session(
      {}, {}, [&] { return std::move(loopback.host); }, steady_clock(),
      [&](const Event& event) {
        if (std::holds_alternative<Connected>(event.what)) connected.set_value();
        if (std::holds_alternative<LineDone>(event.what) && ++lines == 3) printing.set_value();
      });
  const auto patience = std::chrono::seconds(20);
  REQUIRE(connected.get_future().wait_for(patience) == std::future_status::ready);
  port->print(std::make_unique<MemorySource>(Lines{"G92 X0 Y0 Z0", "M83"} + moves(100)));
  REQUIRE(printing.get_future().wait_for(patience) == std::future_status::ready);
  port->halt("button");
  port.reset();
  CHECK(printer.aborts() >= 1);
}
