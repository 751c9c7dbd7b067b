#include "tests/daemon/full_disk.h"

#include <future>

#include <catch2/catch.hpp>

/// What happens while nothing can be written: the disk is full for a while.
namespace voidpath::test {

using daemon::State;
namespace fs = std::filesystem;

TEST_CASE("what was prepared while the disk was full is kept once there is room") {
  bool complained = false;
  RunnerRig rig;
  rig.log =
      daemon::EventLog([&](const std::string&, const std::string&,
                           const std::string& text) { complained |= text.find("disk is full") != text.npos; },
                       false);
  std::promise<void> disk_is_full;
  rig.prepare = [&, prepare = rig.prepare](const daemon::PrepareTask& task, const run::Context& ctx) {
    disk_is_full.get_future().wait();
    return prepare(task, ctx);
  };
  rig.connect();
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::preparing));
  {
    const FullDisk full(rig);
    disk_is_full.set_value();
    REQUIRE(rig.loop.run_until([&] { return complained; }));
    CHECK(rig.state_of("a.stl") == State::preparing);
    rig.loop.advance(12);
    CHECK(rig.state_of("a.stl") == State::preparing);
  }
  rig.loop.advance(6);
  REQUIRE(rig.reaches("a.stl", State::waiting_bed));
  CHECK(rig.runner->queue()[0]->facts.predicted_s == 100);
}

TEST_CASE("a start that could not be kept is decided anew, not repeated") {
  RunnerRig rig;
  rig.connect();
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::waiting_bed));
  {
    rig.runner->bed_clear("");
    const FullDisk full(rig);
    rig.loop.run();
    CHECK(rig.printer.count("print") == 0);
    rig.runner->halted("", "emergency stop");
  }
  rig.loop.advance(30);
  CHECK(rig.state_of("a.stl") == State::waiting_bed);
  CHECK(rig.printer.count("print") == 0);
}

TEST_CASE("the times of a print that ended on a full disk are not lost") {
  RunnerRig rig;
  rig.connect();
  rig.runner->bed_clear("");
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.begin_motion();
  {
    const FullDisk full(rig);
    rig.finish(50);
    rig.loop.advance(12);
    CHECK(rig.store->history().empty());
  }
  rig.loop.advance(6);
  REQUIRE(rig.loop.run_until([&] { return rig.store->history().size() == 1; }));
  CHECK(rig.store->history()[0].state == "done");
  CHECK(rig.store->history()[0].measured_s.has_value());
  CHECK(fs::exists(rig.dir / "inbox/done/a.stl"));
}

TEST_CASE("an upload that could not be kept is refused and leaves nothing in the folder") {
  RunnerRig rig;
  const FullDisk full(rig);
  const fs::path upload = rig.dir.write("inbox/.voidpath-upload-abc123", "solid\nendsolid\n");
  CHECK_THROWS_AS(rig.runner->add(upload, "a.stl", {}, ""), daemon::StoreError);
  CHECK_FALSE(fs::exists(rig.dir / "inbox/a.stl"));
  CHECK(rig.runner->queue().empty());
}

TEST_CASE("an upload whose naming was cut short gets its name at the next start, strays go") {
  RunnerRig rig;
  const fs::path upload = rig.dir.write("inbox/.voidpath-upload-abc123", "solid\nendsolid\n");
  daemon::JobOptions options;
  options.copies = 2;
  {
    // The row as add() commits it, and no further.
    daemon::Job job;
    job.printer = "left";
    job.folder = rig.dir / "inbox";
    job.input = rig.dir / "inbox/a.stl";
    job.location = upload;
    job.file = *daemon::identify(upload);
    job.options = options;
    auto change = rig.store->begin();
    rig.store->insert(job);
    change.commit();
  }
  rig.dir.write("inbox/.voidpath-upload-stray1", "half");
  rig.restart();
  CHECK(fs::exists(rig.dir / "inbox/a.stl"));
  CHECK_FALSE(fs::exists(upload));
  CHECK_FALSE(fs::exists(rig.dir / "inbox/.voidpath-upload-stray1"));
  REQUIRE(rig.runner->queue().size() == 1);
  CHECK(rig.runner->queue()[0]->options.copies == 2);
}

TEST_CASE("heaters of a print that was cut off go off at the next connection, even after another restart") {
  RunnerRig rig;
  rig.connect();
  rig.runner->bed_clear("");
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.printer.say(fw::Disconnected{"cable"});
  rig.loop.run();
  rig.restart();
  rig.restart();
  CHECK(rig.printer.count("command M104 S0") == 0);
  rig.connect();
  CHECK(rig.printer.count("command M104 S0") == 1);
  CHECK(rig.printer.count("command M140 S0") == 1);
  rig.restart();
  rig.connect();
  CHECK(rig.printer.count("command M104 S0") == 1);
}

}  // namespace voidpath::test
