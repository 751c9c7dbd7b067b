#include "daemon/jobs/runner.h"

#include "daemon/json/json.h"
#include "tests/daemon/fakes.h"

#include <algorithm>
#include <string>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>

using namespace voidpath::test;
using namespace voidpath::daemon;
namespace fw = voidpath::fw;
namespace fs = std::filesystem;

TEST_CASE("a dropped file is prepared, waits for a clear bed, prints, and is filed with its times") {
  RunnerRig rig;
  rig.connect();
  const auto file = rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::waiting_bed));
  CHECK(rig.printer.count("print") == 0);
  CHECK(rig.runner->waiting_reason(*rig.runner->printers()[0]).find("bed-clear") != std::string::npos);

  rig.runner->bed_clear("");
  REQUIRE(rig.reaches("a.stl", State::heating));
  CHECK(rig.printer.count("print") == 1);
  CHECK_FALSE(rig.runner->printers()[0]->memory.bed_clear);
  rig.begin_motion();
  CHECK(rig.state_of("a.stl") == State::printing);
  rig.finish(80);

  CHECK_FALSE(fs::exists(file));
  CHECK(fs::exists(rig.dir / "inbox/done/a.stl"));
  const auto history = rig.store->history();
  REQUIRE(history.size() == 1);
  CHECK(history[0].state == "done");
  CHECK(history[0].measured_s == Approx(80));
  CHECK(history[0].heating_s == Approx(30));
  CHECK(history[0].total_s == Approx(112));
  CHECK(history[0].firmware == "Marlin test");
  REQUIRE(history[0].layer_measured_s.size() == 2);
  CHECK(history[0].layer_measured_s[0] == Approx(20));
  CHECK(history[0].layer_measured_s[1] == Approx(40));
  const Json report = Json::parse(read_all(rig.dir / "inbox/done/a.stl.report.json"));
  CHECK(report["measured_s"].number() == Approx(80));
  CHECK(read_all(rig.dir / "inbox/done/a.stl.report.txt").find("a.stl: done") != std::string::npos);
  CHECK_FALSE(fs::exists(rig.config.state_dir / "jobs" / "1"));
}

TEST_CASE("one print at a time, in order; each waits for its own clear bed") {
  RunnerRig rig;
  rig.connect();
  rig.runner->bed_clear("");
  rig.drop("a.stl");
  rig.drop("b.stl");
  REQUIRE(rig.reaches("a.stl", State::heating));
  REQUIRE(rig.reaches("b.stl", State::ready));
  CHECK_THROWS_AS(rig.runner->bed_clear(""), CommandError);  // not while it prints
  rig.begin_motion();
  rig.finish(50);
  REQUIRE(rig.reaches("b.stl", State::waiting_bed));
  CHECK(rig.printer.count("print") == 1);
  rig.runner->bed_clear("");
  REQUIRE(rig.reaches("b.stl", State::heating));
  CHECK(rig.printer.count("print") == 2);
}

TEST_CASE("with auto_clear the next one starts after a finished print, but not after a failed one") {
  RunnerRig rig(true);
  rig.connect();
  for (const char* name : {"a.stl", "b.stl", "c.stl"}) rig.drop(name);
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.begin_motion();
  rig.finish(50);
  REQUIRE(rig.reaches("b.stl", State::heating));
  rig.begin_motion();
  rig.printer.say(fw::PrintFailed{"thermal runaway"});
  REQUIRE(rig.reaches("c.stl", State::waiting_bed));
  CHECK(rig.printer.count("print") == 2);
  const auto history = rig.store->history();
  REQUIRE(history.size() == 2);
  CHECK(history[1].state == "failed");
  CHECK(history[1].reason == "thermal runaway");
  CHECK_FALSE(history[1].measured_s);
  CHECK(fs::exists(rig.dir / "inbox/failed/b.stl"));
}

namespace {

/// What is said to a printer that is there again after a print was cut off.
std::vector<std::string> said_after_cut_off(const fw::FirmwareInfo& firmware) {
  RunnerRig rig(true);
  rig.connect();
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.restart();
  rig.printer.calls.clear();
  rig.printer.say(fw::Connected{firmware});
  rig.loop.run();
  return rig.printer.calls;
}

}  // namespace

TEST_CASE("after a print that was cut off every heater of the printer is turned off") {
  fw::FirmwareInfo two;
  two.name = "Marlin test";
  two.extruders = 2;
  two.capabilities["CHAMBER_TEMPERATURE"] = true;
  const auto said = said_after_cut_off(two);
  for (const char* line : {"M104 S0", "M104 T0 S0", "M104 T1 S0", "M140 S0", "M141 S0", "M107"})
    CHECK(std::count(said.begin(), said.end(), "command " + std::string(line)) == 1);
}

TEST_CASE("a Klipper, which does not say how many hotends it has, turns all off after a cut-off print") {
  fw::FirmwareInfo klipper;
  klipper.name = "Klipper";
  const auto said = said_after_cut_off(klipper);
  CHECK(std::count(said.begin(), said.end(), "command TURN_OFF_HEATERS") == 1);
}

TEST_CASE("nothing starts while the printer is not connected") {
  RunnerRig rig(true);
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::waiting_bed));
  CHECK(rig.printer.calls.empty());
  rig.connect();
  CHECK(rig.reaches("a.stl", State::heating));
}

TEST_CASE("cancel ends the print through the printer, and the record tells") {
  RunnerRig rig;
  rig.connect();
  rig.runner->bed_clear("");
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.begin_motion();
  rig.runner->cancel(std::nullopt, "");
  CHECK(rig.state_of("a.stl") == State::cancelling);
  CHECK(rig.printer.count("cancel") == 1);
  rig.runner->cancel(std::nullopt, "");  // it may wait at its panel again
  CHECK(rig.state_of("a.stl") == State::cancelling);
  CHECK(rig.printer.count("cancel") == 2);
  rig.printer.say(fw::PrintCancelled{}, 2);
  rig.loop.run();
  REQUIRE(rig.store->history().size() == 1);
  CHECK(rig.store->history()[0].state == "cancelled");
  CHECK_FALSE(rig.runner->printers()[0]->memory.bed_clear);
  CHECK(fs::exists(rig.dir / "inbox/failed/a.stl"));
  CHECK_THROWS_AS(rig.runner->cancel(std::nullopt, ""), CommandError);
}

TEST_CASE("pauses are not motion, whoever paused") {
  RunnerRig rig;
  rig.connect();
  rig.runner->bed_clear("");
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.begin_motion();
  rig.runner->pause("");
  CHECK(rig.printer.count("pause") == 1);
  rig.printer.say(fw::Paused{false, ""}, 10);
  rig.loop.run();
  CHECK(rig.state_of("a.stl") == State::paused);
  rig.runner->resume("");
  CHECK(rig.printer.count("resume") == 1);
  rig.printer.say(fw::Resumed{}, 500);
  rig.loop.run();
  CHECK(rig.state_of("a.stl") == State::printing);
  rig.printer.say(fw::Paused{true, "filament runout"}, 5);
  rig.loop.run();
  CHECK(rig.runner->job_on(*rig.runner->printers()[0])->message == "filament runout");
  rig.printer.say(fw::Message{"busy: paused for user"}, 1);
  rig.printer.say(fw::Message{"the printer asks: Continue?; M876 S0: Yes", true});
  rig.loop.run();
  CHECK(rig.runner->job_on(*rig.runner->printers()[0])->message ==
        "the printer asks: Continue?; M876 S0: Yes");
  rig.printer.say(fw::Resumed{}, 60);
  rig.finish(85);
  const auto history = rig.store->history();
  REQUIRE(history.size() == 1);
  CHECK(history[0].measured_s == Approx(100));
  CHECK(history[0].paused_s == Approx(561));
}

TEST_CASE("a crash during a print leaves it interrupted, unasked nothing prints again") {
  RunnerRig rig(true);
  rig.connect();
  rig.drop("a.stl");
  rig.drop("b.stl");
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.begin_motion();
  rig.restart();
  rig.connect();
  CHECK(rig.state_of("a.stl") == State::interrupted);
  REQUIRE(rig.reaches("b.stl", State::waiting_bed));  // the bed is not known to be clear
  CHECK(rig.printer.count("print") == 1);
  for (const char* off : {"command M104 S0", "command M140 S0"}) CHECK(rig.printer.count(off) == 1);
  REQUIRE(rig.store->history().size() == 1);
  CHECK(rig.store->history()[0].state == "interrupted");
  CHECK_FALSE(rig.store->history()[0].measured_s);

  // The file is still in its folder and belongs to that job: a scan does not take it again.
  const auto file = rig.dir / "inbox/a.stl";
  REQUIRE(fs::exists(file));
  CHECK(rig.runner->owns(file, *identify(file)));
  rig.runner->take({file, *identify(file)});
  CHECK(rig.runner->queue().size() == 2);

  rig.runner->resume_interrupted(rig.id_of("a.stl"));
  rig.loop.run();
  CHECK(rig.printer.count("print") == 1);  // still not before the bed is clear
  rig.runner->bed_clear("");
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.begin_motion();
  rig.finish(50);
  CHECK(fs::exists(rig.dir / "inbox/done/a.stl"));
  CHECK(rig.store->history().back().state == "done");
}

TEST_CASE("an interrupted one can be given up; its file leaves the folder") {
  RunnerRig rig(true);
  rig.connect();
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.restart();
  const auto id = rig.id_of("a.stl");
  rig.runner->discard(id);
  CHECK(rig.runner->queue().empty());
  CHECK(fs::exists(rig.dir / "inbox/failed/a.stl"));
  CHECK(rig.store->history().size() == 1);
  CHECK_THROWS_AS(rig.runner->discard(id), CommandError);
}

TEST_CASE("a crash while preparing prepares anew, and prints once") {
  RunnerRig rig(true);
  rig.connect();
  const auto quick = rig.prepare;
  rig.prepare = [](const PrepareTask&, const voidpath::run::Context& ctx) {
    while (!ctx.stop.stop_requested()) std::this_thread::yield();
    PrepareResult result;
    result.kind = PrepareResult::Kind::stopped;
    return result;
  };
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::preparing));
  rig.runner.reset();
  rig.prepare = quick;
  rig.restart();
  rig.connect();
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.begin_motion();
  rig.finish(50);
  CHECK(rig.store->history().size() == 1);
  CHECK(rig.printer.count("print") == 1);
}

TEST_CASE("shutting down ends the print safely and leaves it interrupted") {
  RunnerRig rig(true);
  rig.connect();
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.begin_motion();
  bool finished = false;
  rig.runner->shutdown([&] { finished = true; });
  rig.loop.run();
  CHECK(rig.printer.count("cancel") == 1);
  CHECK_FALSE(finished);  // not before the printer has done it
  rig.printer.say(fw::PrintCancelled{}, 1);
  rig.loop.run();
  CHECK(finished);
  CHECK(rig.state_of("a.stl") == State::interrupted);
  REQUIRE(rig.store->history().size() == 1);
  CHECK(rig.store->history()[0].state == "interrupted");
}

TEST_CASE("shutting down does not wait for ever for a printer that does not answer") {
  RunnerRig rig(true);
  rig.connect();
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::heating));
  bool finished = false;
  rig.runner->shutdown([&] { finished = true; });
  rig.loop.advance(60);
  CHECK(finished);
}

TEST_CASE("an emergency stop holds the queue until someone says that the bed is clear") {
  RunnerRig rig(true);
  rig.connect();
  rig.drop("a.stl");
  rig.drop("b.stl");
  REQUIRE(rig.reaches("a.stl", State::heating));
  REQUIRE(rig.reaches("b.stl", State::ready));
  rig.runner->halted("", "emergency stop");
  rig.printer.say(fw::PrintFailed{"halted"});
  rig.loop.run();
  CHECK(rig.printer.count("halt") >= 1);
  CHECK(rig.store->history()[0].state == "failed");
  CHECK(rig.store->history()[0].reason == "emergency stop");
  CHECK(rig.state_of("b.stl") == State::waiting_bed);
  rig.restart();  // and a restart does not forget it
  rig.connect();
  REQUIRE(rig.reaches("b.stl", State::waiting_bed));
  CHECK(rig.printer.count("print") == 1);
  rig.runner->bed_clear("");
  CHECK(rig.reaches("b.stl", State::heating));
}

TEST_CASE("copies print one after the other, each with its row and its clear bed") {
  RunnerRig rig;
  rig.connect();
  rig.runner->bed_clear("");
  const auto upload = rig.dir.write("inbox/.upload", "solid\nendsolid\n");
  JobOptions options;
  options.copies = 2;
  rig.runner->add(upload, "a.stl", options, "");
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.begin_motion();
  rig.finish(50);
  REQUIRE(rig.reaches("a.stl", State::waiting_bed));
  CHECK(rig.printer.count("print") == 1);
  rig.runner->bed_clear("");
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.begin_motion();
  rig.finish(60);
  CHECK(rig.runner->queue().empty());
  const auto history = rig.store->history();
  REQUIRE(history.size() == 2);
  CHECK(history[0].state == "done");
  CHECK(history[1].state == "done");
  CHECK(history[1].measured_s == Approx(60));
  CHECK(fs::exists(rig.dir / "inbox/done/a.stl"));
}

TEST_CASE("a refused file is filed with the reason, has a row, and can be tried again") {
  RunnerRig rig;
  const auto good = rig.prepare;
  rig.prepare = [](const PrepareTask&, const voidpath::run::Context&) {
    PrepareResult result;
    result.kind = PrepareResult::Kind::failed;
    result.message = "a.stl: no triangles";
    return result;
  };
  rig.drop("a.stl");
  REQUIRE(rig.loop.run_until([&] { return !rig.store->history().empty(); }));
  CHECK(rig.store->history()[0].state == "failed");
  CHECK(rig.store->history()[0].reason == "a.stl: no triangles");
  CHECK(rig.store->history()[0].started.empty());
  CHECK(fs::exists(rig.dir / "inbox/failed/a.stl"));
  rig.prepare = good;
  rig.runner->retry(1);
  CHECK(rig.reaches("a.stl", State::waiting_bed));
  rig.connect();
  rig.runner->bed_clear("");
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.begin_motion();
  rig.finish(50);
  CHECK(fs::exists(rig.dir / "inbox/done/a.stl"));
  CHECK_FALSE(fs::exists(rig.dir / "inbox/failed/a.stl"));
}

TEST_CASE("a file that is replaced before it prints is prepared anew; while it prints, it is a new job") {
  RunnerRig rig;
  rig.connect();
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::waiting_bed));
  rig.drop("a.stl", "solid other\nendsolid other\n");
  CHECK(rig.state_of("a.stl") == State::received);
  REQUIRE(rig.reaches("a.stl", State::waiting_bed));
  CHECK(rig.runner->queue().size() == 1);
  rig.runner->bed_clear("");
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.drop("a.stl", "solid third one\nendsolid third one\n");
  CHECK(rig.runner->queue().size() == 2);
  rig.begin_motion();
  rig.finish(50);
  // The new one is not filed in the old one's name.
  CHECK(fs::exists(rig.dir / "inbox/a.stl"));
  CHECK(rig.runner->queue().size() == 1);
}

TEST_CASE("a file renamed in its folder stays one job") {
  RunnerRig rig;
  const auto file = rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::waiting_bed));
  fs::rename(file, rig.dir / "inbox/b.stl");
  rig.runner->take({rig.dir / "inbox/b.stl", *identify(rig.dir / "inbox/b.stl")});
  CHECK(rig.runner->queue().size() == 1);
  CHECK(rig.state_of("b.stl") == State::waiting_bed);
}

TEST_CASE("a file that turns out to be in the making goes back to settling") {
  RunnerRig rig;
  int tries = 0;
  const auto good = rig.prepare;
  rig.prepare = [&](const PrepareTask& task, const voidpath::run::Context& ctx) {
    PrepareResult result = good(task, ctx);
    if (tries++ == 0) result.kind = PrepareResult::Kind::unsettled;
    return result;
  };
  const auto file = rig.drop("a.stl");
  REQUIRE(rig.loop.run_until([&] { return rig.settler->pending(file); }));
  CHECK(rig.state_of("a.stl") == State::received);
  CHECK(tries == 1);
  rig.runner->take({file, *identify(file)});
  rig.settler->poll(1000);  // settled: no longer pending
  rig.runner->take({file, *identify(file)});
  CHECK(rig.reaches("a.stl", State::waiting_bed));
  CHECK(rig.runner->queue().size() == 1);
}

TEST_CASE("a MakerBot's files are prepared for the machine that its port speaks to") {
  RunnerRig rig;
  rig.port_options.s3g.emplace().extruders = 2;
  rig.restart();
  int extruders = 0;
  const auto good = rig.prepare;
  rig.prepare = [&](const PrepareTask& task, const voidpath::run::Context& ctx) {
    if (task.s3g) extruders = task.s3g->extruders;
    return good(task, ctx);
  };
  rig.drop("a.gcode");
  REQUIRE(rig.reaches("a.gcode", State::waiting_bed));
  CHECK(extruders == 2);
}

TEST_CASE("a file taken out of the folder before its turn is not printed") {
  RunnerRig rig;
  rig.connect();
  const auto file = rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::waiting_bed));
  fs::remove(file);
  rig.runner->bed_clear("");
  rig.loop.run();
  CHECK(rig.printer.count("print") == 0);
  CHECK(rig.runner->queue().empty());
}

TEST_CASE("the queue can be reordered, and remembers it") {
  RunnerRig rig;
  for (const char* name : {"a.stl", "b.stl", "c.stl"}) rig.drop(name);
  REQUIRE(rig.reaches("a.stl", State::waiting_bed));
  REQUIRE(rig.reaches("c.stl", State::ready));
  rig.runner->move(rig.id_of("c.stl"), 1);
  REQUIRE(rig.reaches("c.stl", State::waiting_bed));
  CHECK(rig.state_of("a.stl") == State::ready);
  rig.restart();
  std::vector<std::string> order;
  for (const auto* job : rig.runner->queue()) order.push_back(job->file_name());
  CHECK(order == std::vector<std::string>{"c.stl", "a.stl", "b.stl"});
}

TEST_CASE("measured prints correct the next prediction once there are enough of them") {
  RunnerRig rig(true);
  rig.connect();
  for (int i = 0; i < 4; ++i) {
    const std::string name = "part" + std::to_string(i) + ".stl";
    rig.drop(name);
    REQUIRE(rig.reaches(name, State::heating));
    const auto* job = rig.runner->job_on(*rig.runner->printers()[0]);
    CHECK(job->facts.predicted_raw_s == Approx(100));
    CHECK(job->facts.predicted_s == Approx(i < 3 ? 100.0 : 120.0));
    rig.begin_motion();
    rig.finish(120);
  }
}

TEST_CASE("a lost connection fails the print that ran") {
  RunnerRig rig(true);
  rig.connect();
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.printer.say(fw::Disconnected{"cable pulled"});
  rig.printer.say(fw::PrintFailed{"cable pulled"});
  rig.loop.run();
  REQUIRE(rig.store->history().size() == 1);
  CHECK(rig.store->history()[0].state == "failed");
  CHECK(rig.store->history()[0].reason.find("cable pulled") != std::string::npos);
}

TEST_CASE("finished names do not overwrite earlier ones") {
  RunnerRig rig(true);
  rig.connect();
  for (int i = 0; i < 2; ++i) {
    rig.drop("a.stl");
    REQUIRE(rig.reaches("a.stl", State::heating));
    rig.begin_motion();
    rig.finish(50);
  }
  CHECK(fs::exists(rig.dir / "inbox/done/a.stl"));
  CHECK(fs::exists(rig.dir / "inbox/done/a-2.stl"));
  CHECK(fs::exists(rig.dir / "inbox/done/a-2.stl.report.json"));
}
