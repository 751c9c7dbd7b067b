#include "daemon/jobs/runner.h"
#include "tests/daemon/fakes.h"

#include <mutex>
#include <optional>
#include <vector>

#include <catch2/catch.hpp>

using namespace voidpath::test;
using namespace voidpath::daemon;
namespace fw = voidpath::fw;

namespace {

/// What the printer's own acceleration was taken to be, job by job, in the order of preparing.
class UsedAccelerations {
 public:
  explicit UsedAccelerations(RunnerRig& rig) {
    rig.prepare = [this, usual = rig.prepare](const PrepareTask& task, const voidpath::run::Context& ctx) {
      {
        const std::lock_guard lock(mutex_);
        used_.push_back(task.firmware ? task.firmware->print_acceleration_mm_s2 : std::nullopt);
      }
      return usual(task, ctx);
    };
  }
  std::size_t size() const { return used_.size(); }
  std::optional<double> operator[](std::size_t i) const { return used_[i]; }
  std::optional<double> back() const { return used_.back(); }

 private:
  std::mutex mutex_;
  std::vector<std::optional<double>> used_;
};

}  // namespace

TEST_CASE("what a printer says of itself goes with every job prepared from then on") {
  RunnerRig rig;
  UsedAccelerations used(rig);
  rig.connect();
  rig.drop("before.stl");
  REQUIRE(rig.reaches("before.stl", State::waiting_bed));
  fw::FirmwareLimits limits;
  limits.print_acceleration_mm_s2 = 700;
  rig.printer.say(fw::LimitsKnown{limits});
  rig.loop.run();
  rig.drop("after.stl");
  REQUIRE(rig.reaches("after.stl", State::ready));
  REQUIRE(used.size() == 2);
  CHECK_FALSE(used[0]);
  CHECK(used[1] == 700.0);
}

TEST_CASE("what a printer said of itself holds for jobs prepared before it answers again") {
  RunnerRig rig;
  rig.config.printers[0].profile = "generic-marlin";
  rig.config.printers[0].port = "/dev/ttyA";
  rig.restart();
  UsedAccelerations used(rig);
  const auto used_for = [&](const std::string& name) {
    rig.drop(name);
    // The first in the queue waits for the bed, the others behind it.
    REQUIRE(rig.loop.run_until([&] {
      const auto state = rig.state_of(name);
      return state == State::waiting_bed || state == State::ready;
    }));
    return used.back();
  };
  const auto answer_as = [&](const std::string& machine) {
    fw::FirmwareInfo info;
    info.name = "Marlin test";
    info.machine = machine;
    rig.printer.say(fw::Connected{info});
    rig.loop.run();
  };
  fw::FirmwareLimits limits;
  limits.print_acceleration_mm_s2 = 700;
  answer_as("one");
  rig.printer.say(fw::LimitsKnown{limits});
  rig.loop.run();

  rig.restart();
  CHECK_FALSE(rig.runner->printer("left").limits_differ.empty());  // told before it is connected, too
  CHECK(used_for("early.stl") == 700.0);
  answer_as("one");
  CHECK(used_for("same.stl") == 700.0);

  SECTION("not once another machine answers, nor after that") {
    answer_as("another");
    CHECK_FALSE(used_for("other.stl"));
    CHECK(rig.runner->printer("left").limits_differ.empty());
    rig.restart();
    CHECK_FALSE(used_for("later.stl"));
  }
  SECTION("not where the configuration names another port") {
    rig.config.printers[0].port = "/dev/ttyB";
    rig.restart();
    CHECK_FALSE(used_for("other.stl"));
  }
}
