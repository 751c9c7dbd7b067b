#include "tests/firmware-io/s3g_prints.h"

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using namespace voidpath::test;

namespace {

/// Until everything has been sent and the printer is still at it.
bool print_to_tail(S3gBench& bench, const Lines& file) {
  bench.print(file);
  return bench.run_until([&] {
    return bench.count<LineDone>() == static_cast<int>(file.size()) && bench.mock.queued_bytes() > 0;
  });
}

/// Having been paused once.
void check_goes_on_to_the_end(S3gBench& bench, const Lines& file) {
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  CHECK(bench.count<Paused>() == 1);
  CHECK(bench.count<Resumed>() == 1);
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK_FALSE(bench.mock.paused());
  check_executed(bench, file);
}

void check_pause_at_panel(S3gBench& bench, const Lines& file, double seconds) {
  bench.mock.press_pause();
  bench.run_for(seconds);
  REQUIRE(bench.count<Paused>() == 1);
  CHECK(std::get<Paused>(bench.first<Paused>()->what).by_printer);
  bench.mock.press_pause();
  check_goes_on_to_the_end(bench, file);
}

}  // namespace

TEST_CASE("a pause by the user stands still and goes on", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  const Lines file = kStart + moves(200) + kEnd;
  REQUIRE(bench.print_into(file, 60));
  bench.driver.pause();
  REQUIRE(bench.run_until([&] { return bench.mock.paused(); }, 5));
  const std::size_t before = bench.executed.size();
  bench.run_for(60);
  CHECK(bench.executed.size() == before);
  CHECK(bench.count<Paused>() == 1);
  bench.driver.resume(bench.t);
  check_goes_on_to_the_end(bench, file);
}

TEST_CASE("a pause at the panel, an hour long, is followed and costs nothing", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  const Lines file = kStart + moves(200) + kEnd;
  REQUIRE(bench.print_into(file, 60));
  check_pause_at_panel(bench, file, 3600);
}

TEST_CASE("a pause while the last moves drain stands still, goes on and comes to an end", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  const Lines file = kStart + moves(60);
  REQUIRE(print_to_tail(bench, file));
  bench.driver.pause();
  REQUIRE(bench.run_until([&] { return bench.mock.paused(); }, 5));
  const std::size_t before = bench.executed.size();
  bench.run_for(60);
  CHECK(bench.executed.size() == before);
  CHECK_FALSE(bench.over());
  CHECK(bench.count<Paused>() == 1);
  bench.driver.resume(bench.t);
  check_goes_on_to_the_end(bench, file);
}

TEST_CASE("a pause when all moves are done and only the end is to be told does not end the print", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  const Lines file = kStart + moves(60);
  REQUIRE(print_to_tail(bench, file));
  REQUIRE(bench.run_until([&] { return bench.mock.drained() && bench.mock.queued_bytes() == 0; }, 60));
  bench.driver.pause();
  bench.run_for(10);
  CHECK_FALSE(bench.over());
  bench.driver.resume(bench.t);
  check_goes_on_to_the_end(bench, file);
}

TEST_CASE("a pause at the panel while the last moves drain is told", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  const Lines file = kStart + moves(60);
  REQUIRE(print_to_tail(bench, file));
  check_pause_at_panel(bench, file, 60);
}

TEST_CASE("a pause before the first line has gone out can be ended", "[s3g]") {
  for (const double after_s : {0.0, 0.001, 0.003, 0.01, 0.03}) {
    S3gBench bench(real_wire());
    REQUIRE(bench.connect());
    bench.run_for(7);
    const Lines file = kStart + moves(20) + kEnd;
    bench.print(file);
    if (after_s > 0) bench.run_for(after_s);
    bench.driver.pause();
    bench.run_for(60);
    INFO("paused " << after_s << " s after the beginning");
    CHECK_FALSE(bench.over());
    CHECK(bench.count<Paused>() == 1);
    CHECK(bench.executed.size() < kStart.size());
    bench.driver.resume(bench.t);
    check_goes_on_to_the_end(bench, file);
  }
}

TEST_CASE("a print from the card is left alone: a job is refused at once and touches nothing", "[s3g]") {
  for (const bool paused : {false, true}) {
    for (const char* then : {"wait", "pause", "cancel"}) {
      S3gBench bench(real_wire());
      REQUIRE(bench.connect());
      bench.run_for(3);
      bench.mock.print_from_card(600);
      bench.run_for(20);
      if (paused) bench.mock.press_pause();
      const double asked = bench.t;
      bench.print(kStart + moves(20));
      if (then == std::string("pause")) bench.driver.pause();
      if (then == std::string("cancel")) bench.driver.cancel("user", bench.t);
      INFO(then << (paused ? ", paused" : ""));
      if (then == std::string("pause")) {
        bench.run_for(5);
        bench.driver.resume(bench.t);
      }
      REQUIRE(bench.run_until([&] { return bench.over(); }, 10));
      if (then == std::string("wait")) {
        CHECK(bench.first<PrintFailed>()->at_s - asked < 0.1);
        CHECK_THAT(bench.failure(), Catch::Contains(paused ? "another print" : "card"));
      }
      bench.run_for(30);
      CHECK(bench.executed.empty());
      CHECK(bench.mock.prints_from_card());
      CHECK(bench.mock.paused() == paused);
      CHECK(bench.mock.aborts() == 0);
      CHECK(bench.mock.drained() == paused);
    }
  }
}

TEST_CASE("a command that a printer refuses during a print from its card is not lost without a word",
          "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  bench.mock.print_from_card(600);
  bench.run_for(20);
  bench.driver.command("M104 S50", bench.t);
  bench.run_for(1);
  CHECK(bench.said("busy with a print from its own card"));
}

TEST_CASE("what an earlier session left running is waited for", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  for (const char* line : {"G4 S10", "G4 S30"}) bench.driver.command(line, bench.t);
  bench.run_for(2);
  const Lines file = kStart + moves(20) + kEnd;
  bench.print(file);
  bench.run_for(20);
  CHECK(bench.said("sent before"));
  bench.executed.clear();
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  REQUIRE(bench.count<PrintFinished>() == 1);
  check_executed(bench, file);
}

TEST_CASE("M0 stands still where the file has come to, with the printer itself paused", "[s3g]") {
  for (const bool at_panel : {false, true}) {
    S3gBench bench(real_wire());
    REQUIRE(bench.connect());
    const Lines file = kStart + moves(20) + Lines{"M600"} + moves(20, 2) + kEnd;
    bench.print(file);
    bool rested = false;
    bench.each_step = [&] {
      if (bench.count<Paused>() == 0) rested = bench.mock.drained() && bench.mock.queued_bytes() == 0;
    };
    REQUIRE(bench.run_until([&] { return bench.count<Paused>() == 1; }));
    CHECK(rested);
    CHECK_FALSE(std::get<Paused>(bench.first<Paused>()->what).by_printer);
    REQUIRE(bench.run_until([&] { return bench.mock.paused(); }, 5));
    bench.run_for(100);
    CHECK(bench.count<Paused>() == 1);
    CHECK_FALSE(bench.over());
    if (at_panel) {
      bench.mock.press_pause();
    } else {
      bench.driver.resume(bench.t);
    }
    REQUIRE(bench.run_until([&] { return bench.over(); }));
    CHECK(bench.count<Resumed>() == 1);
    CHECK(bench.count<PrintFinished>() == 1);
    CHECK(bench.count<LineDone>() == static_cast<int>(file.size()));
    check_executed(bench, file);
  }
}

TEST_CASE("a pause by the user just before M0 does not take its place", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  const Lines file = kStart + moves(20) + Lines{"M0"} + moves(20, 2) + kEnd;
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() >= 30 && bench.mock.queued_bytes() < 200; }));
  bench.driver.pause();
  bench.run_for(60);
  bench.driver.resume(bench.t);
  REQUIRE(bench.run_until([&] { return bench.count<Paused>() == 2; }));
  bench.run_for(10);
  CHECK(bench.mock.paused());
  bench.driver.resume(bench.t);
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  CHECK(bench.count<Resumed>() == 2);
  check_executed(bench, file);
}

TEST_CASE("a pause that waits its turn ends with its print", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  REQUIRE(bench.print_into(kStart + moves(300) + kEnd, 60));
  const double begun = bench.t;
  const auto at = [&](double seconds) { bench.run_for(begun + seconds - bench.t); };
  bench.driver.pause();
  at(2.1);
  bench.driver.resume(bench.t);
  at(2.5);
  // Too soon after the last: held back.
  bench.driver.pause();
  at(3);
  CHECK_FALSE(bench.mock.paused());
  bench.driver.cancel("user", bench.t);
  REQUIRE(bench.run_until([&] { return bench.over(); }, 5));
  bench.run_for(30);
  CHECK_FALSE(bench.mock.paused());
  check_next_print(bench);
}

TEST_CASE("a cancel at any moment of a pause leaves no printer paused", "[s3g]") {
  for (const double after_s : {0.0, 0.001, 0.003, 0.005, 0.01, 0.02, 0.5, 2.5}) {
    S3gBench bench(real_wire());
    REQUIRE(bench.connect());
    REQUIRE(bench.print_into(kStart + moves(300) + kEnd, 60));
    bench.driver.pause();
    if (after_s > 0) bench.run_for(after_s);
    bench.driver.cancel("user", bench.t);
    INFO("cancelled " << after_s << " s after the pause");
    REQUIRE(bench.run_until([&] { return bench.over(); }, 5));
    CHECK(bench.count<PrintCancelled>() == 1);
    bench.run_for(30);
    CHECK_FALSE(bench.mock.paused());
    CHECK(bench.mock.hotend().target() == 0);
    check_next_print(bench);
  }
}

namespace {

const Lines kLongFile = Lines{"M136", "G92 X0 Y0 Z0", "M83", "M104 S100"} + moves(100) + kEnd;

/// A print in which the reply to a move of filament was lost and only the rest will show what became of it.
std::unique_ptr<S3gBench> print_with_a_doubt() {
  for (double lost = 30; lost < 60; ++lost) {
    mock::S3gOptions o =
        real_wire({{.kind = mock::FaultKind::kLoseOk, .at = lost, .trigger = mock::FaultTrigger::kOk}});
    o.counts_lines = false;
    auto bench = std::make_unique<S3gBench>(o);
    REQUIRE(bench->connect());
    bench->print(kLongFile);
    int asked = 0;
    bench->on_output = [&](const std::string& bytes) {
      const bool is_finished = bytes.find(s3g::frame(s3g::Payload(s3g::Query::finished).bytes())) == 0;
      asked += is_finished && bench->mock.queued_bytes() > 200;
    };
    bench->run_until([&] { return asked > 2; }, 10);
    bench->on_output = nullptr;
    if (asked > 2) return bench;
  }
  FAIL("no such reply");
  return nullptr;
}

}  // namespace

TEST_CASE("a pause is heard while the fate of a command is open", "[s3g]") {
  const auto bench = print_with_a_doubt();
  bench->driver.pause();
  REQUIRE(bench->run_until([&] { return bench->mock.paused(); }, 0.5));
  bench->run_for(60);
  CHECK(bench->mock.queued_bytes() > 0);
  bench->driver.resume(bench->t);
  check_goes_on_to_the_end(*bench, kLongFile);
}

TEST_CASE("a pause at the panel is noticed while the fate of a command is open", "[s3g]") {
  const auto bench = print_with_a_doubt();
  bench->mock.press_pause();
  REQUIRE(bench->run_until([&] { return bench->count<Paused>() == 1; }, 4));
  bench->run_for(60);
  CHECK(bench->count<Temperatures>() > 10);
  SECTION("and goes on") {
    bench->mock.press_pause();
    check_goes_on_to_the_end(*bench, kLongFile);
  }
  SECTION("and can be cancelled") {
    bench->driver.cancel("user", bench->t);
    REQUIRE(bench->run_until([&] { return bench->over(); }, 1));
    bench->run_for(10);
    CHECK(bench->mock.hotend().target() == 0);
    CHECK(bench->mock.queued_bytes() == 0);
  }
}

TEST_CASE("a cancel is heard while the fate of a command is open", "[s3g]") {
  const auto bench = print_with_a_doubt();
  const std::size_t before = bench->executed.size();
  bench->driver.cancel("user", bench->t);
  REQUIRE(bench->run_until([&] { return bench->over(); }, 1));
  CHECK(bench->count<PrintCancelled>() == 1);
  bench->run_for(10);
  CHECK(bench->executed.size() < before + 8);
  CHECK(bench->mock.hotend().target() == 0);
  CHECK(bench->mock.aborts() == 0);
}
