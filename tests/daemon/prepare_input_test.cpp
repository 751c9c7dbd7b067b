#include "daemon/jobs/prepare_worker.h"
#include "tests/daemon/temp_dir.h"

#include <catch2/catch.hpp>

using namespace voidpath::daemon;

namespace {

/// Ready G-code in a watched folder, as overrides see it.
struct Inbox {
  voidpath::test::TempDir dir;

  PrepareResult prepare(const std::string& input, const JobOptions& options = {},
                        std::optional<voidpath::fw::FirmwareLimits> firmware = {}) const {
    PrepareTask task;
    task.firmware = std::move(firmware);
    task.input = dir.write("inbox/" + input, "G28\nG1 X10 Y10 E1 F1200\n");
    task.file = *identify(task.input);
    task.options = options;
    task.folder = dir / "inbox";
    task.gcode_out = dir / "state/1/print.gcode";
    task.printer.profile = "generic-marlin";
    auto result = prepare_input(task, {});
    INFO(result.message);
    CHECK(result.kind == PrepareResult::Kind::prepared);
    return result;
  }
};

}  // namespace

TEST_CASE("the nearest override counts, also when it says one") {
  const Inbox inbox;
  inbox.dir.write("inbox/.voidpath.yaml", "copies: 5\n");
  inbox.dir.write("inbox/a.voidpath.yaml", "copies: 1\nscale: 1\n");
  inbox.dir.write("inbox/c.voidpath.yaml", "method: thesis\n");
  CHECK(inbox.prepare("a.gcode").copies == 1);
  CHECK(inbox.prepare("b.gcode").copies == 5);
  CHECK(inbox.prepare("c.gcode").copies == 5);
  CHECK(inbox.prepare("b.gcode", {"", 0, 1}).copies == 1);
}

TEST_CASE("a print is predicted with the printer's own limits where it told them") {
  const Inbox inbox;
  const auto by_profile = inbox.prepare("a.gcode").facts;
  CHECK(by_profile.limits_from == "profile");
  voidpath::fw::FirmwareLimits slow;
  slow.print_acceleration_mm_s2 = 100;
  const auto by_printer = inbox.prepare("b.gcode", {}, slow).facts;
  CHECK(by_printer.limits_from == "printer");
  CHECK(by_printer.limits.find("print 100,") != std::string::npos);
  CHECK(by_printer.predicted_s > by_profile.predicted_s);
  CHECK(by_printer.profile_sha256 != by_profile.profile_sha256);  // what was learned before does not count
}

TEST_CASE("what stood beside a file counts when it is tried again from another folder") {
  const Inbox inbox;
  inbox.dir.write("inbox/a.voidpath.yaml", "copies: 3\n");
  CHECK(inbox.prepare("failed/a.gcode").copies == 3);
  // A second of that name was moved under another one; its report knows.
  inbox.dir.write("inbox/failed/a-2.gcode.report.json", "{\"file\": \"a.gcode\"}\n");
  CHECK(inbox.prepare("failed/a-2.gcode").copies == 3);
  CHECK(inbox.prepare("failed/a-3.gcode").copies == 1);
  inbox.dir.write("inbox/failed/a.voidpath.yaml", "copies: 2\n");
  CHECK(inbox.prepare("failed/a.gcode").copies == 2);
}

TEST_CASE("G-code that would be refused in mid-print fails before it is printed") {
  const voidpath::test::TempDir dir;
  const std::string good = "; by hand\nG28\nG1 X10 Y10 Z1 F1200\n";
  const auto prepare = [&](const std::string& text, bool makerbot = true) {
    PrepareTask task;
    task.input = dir.write("inbox/part.gcode", text);
    task.file = *identify(task.input);
    task.folder = dir / "inbox";
    task.gcode_out = dir / "state/1/print.gcode";
    task.printer.profile = "makerbot-replicator-2";
    if (makerbot) task.s3g.emplace();
    return prepare_input(task, {});
  };
  CHECK(prepare(good).kind == PrepareResult::Kind::prepared);
  const auto refused = prepare(good + "G5 X1 Y1\n");
  CHECK(refused.kind == PrepareResult::Kind::failed);
  CHECK(refused.message.starts_with((dir / "inbox/part.gcode").string() + ": line 4: G5 X1 Y1: "));
  CHECK_FALSE(std::filesystem::exists(dir / "state/1/print.gcode"));
  CHECK(prepare(good + "G5 X1 Y1\n", false).kind == PrepareResult::Kind::prepared);
  for (const bool makerbot : {false, true}) {
    const auto binary = prepare(good + std::string("G1 X2\0\n", 7), makerbot);
    CHECK(binary.kind == PrepareResult::Kind::failed);
    CHECK(binary.message.starts_with((dir / "inbox/part.gcode").string() + ": "));
    const auto endless = prepare(good + "M92 " + std::string(300, 'X') + "\n", makerbot);
    CHECK(endless.kind == PrepareResult::Kind::failed);
    CHECK(
        endless.message.starts_with((dir / "inbox/part.gcode").string() + ":4: a command of 304 characters"));
  }
}
