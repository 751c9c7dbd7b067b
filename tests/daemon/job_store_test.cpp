#include "daemon/jobs/job_store.h"

#include "daemon/jobs/database.h"
#include "tests/daemon/temp_dir.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <catch2/catch.hpp>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace voidpath::daemon;
using voidpath::test::TempDir;

namespace {

Job some_job(const std::string& name, std::uint64_t inode) {
  Job job;
  job.printer = "left";
  job.folder = "/inbox";
  job.input = "/inbox/" + name;
  job.location = job.input;
  job.file = {7, inode, 100, 1'700'000'000'123'456'789};
  job.received = "2026-01-01T00:00:00Z";
  return job;
}

JobFacts some_facts() {
  JobFacts facts;
  facts.model_sha256 = "m";
  facts.profile_sha256 = "p";
  facts.method = "toolpath";
  facts.direction = {0.1, -0.2, 0.3};
  facts.criteria = voidpath::orient::Criteria{1.5, 2.5, 3.5, 4.5};
  facts.why = "because \"so\" = ö";
  facts.predicted_raw_s = 1234.5678901234567;
  facts.predicted_s = 1300;
  facts.as_delivered_s = 2000;
  facts.as_delivered_is_rough = true;
  facts.layers = 2;
  facts.filament_mm = 99.25;
  facts.layer_times = {{0.2, 15, 600}, {0.4, 9999, 634.5}};
  facts.notes = {"one", "two"};
  return facts;
}

PrintRecord done(double predicted, double measured, const std::string& profile = "p") {
  PrintRecord record;
  record.state = "done";
  record.printer = "left";
  record.firmware = "f";
  record.facts.profile_sha256 = profile;
  record.facts.predicted_raw_s = predicted;
  record.measured_s = measured;
  return record;
}

/// Takes jobs in and starts them, telling of each step once it is committed, until it is killed.
[[noreturn]] void work_until_killed(const std::filesystem::path& file, int pipe) {
  JobStore store(file);
  for (std::uint64_t n = 1;; ++n) {
    Job job = some_job("a" + std::to_string(n) + ".stl", n);
    {
      auto change = store.begin();
      store.insert(job);
      change.commit();
    }
    if (::write(pipe, "i", 1) != 1) _exit(1);
    {
      auto change = store.begin();
      PrintRecord record;
      record.job = job.id;
      store.open_record(record);
      job.state = State::heating;
      store.save_printer("left", {true, false, "", "f"});
      store.save(job);
      change.commit();
    }
    if (::write(pipe, "h", 1) != 1) _exit(1);
  }
}

}  // namespace

TEST_CASE("jobs come back as they were saved") {
  TempDir dir;
  Job job = some_job("a.stl", 1);
  {
    JobStore store(dir / "db");
    store.insert(job);
    CHECK(job.id > 0);
    CHECK(job.position == 1);
    job.state = State::ready;
    job.facts = some_facts();
    job.options = {"as-delivered", 2.5, 3, "cura-engine"};
    job.copies = 3;
    job.copies_done = 1;
    job.message = "it's \"ready\"";
    store.save(job);
  }
  JobStore store(dir / "db");
  const auto back = store.job(job.id);
  REQUIRE(back);
  CHECK(back->state == State::ready);
  CHECK(back->file == job.file);
  CHECK(back->input == job.input);
  CHECK(back->message == job.message);
  CHECK(back->copies == 3);
  CHECK(back->copies_done == 1);
  CHECK(back->options.method == "as-delivered");
  CHECK(back->options.scale == 2.5);
  CHECK(back->options.slicer == "cura-engine");
  CHECK(back->facts.direction == job.facts.direction);
  CHECK(back->facts.criteria->void_mm == 4.5);
  CHECK_FALSE(back->facts.criteria_as_delivered);
  CHECK(back->facts.predicted_raw_s == job.facts.predicted_raw_s);
  CHECK(back->facts.as_delivered_s == 2000);
  CHECK(back->facts.as_delivered_is_rough);
  CHECK(back->facts.why == job.facts.why);
  REQUIRE(back->facts.layer_times.size() == 2);
  CHECK(back->facts.layer_times[1].first_line == 9999);
  CHECK(back->facts.layer_times[1].seconds == 634.5);
  CHECK(back->facts.notes == job.facts.notes);
  CHECK_FALSE(store.job(job.id + 1));
}

TEST_CASE("a file that is not filed yet cannot become a second job") {
  TempDir dir;
  JobStore store(dir / "db");
  Job first = some_job("a.stl", 1);
  store.insert(first);
  Job second = some_job("a.stl", 1);
  CHECK_THROWS_AS(store.insert(second), StoreError);
  first.state = State::done;
  first.filed = true;
  store.save(first);
  CHECK_NOTHROW(store.insert(second));
  CHECK(second.position > first.position);
}

TEST_CASE("open jobs are those not ended, and those ended but not filed") {
  TempDir dir;
  JobStore store(dir / "db");
  std::uint64_t inode = 0;
  for (const State state :
       {State::received, State::done, State::failed, State::interrupted, State::cancelled}) {
    for (const bool filed : {false, true}) {
      Job job = some_job("x.stl", ++inode);
      job.state = state;
      job.filed = filed;
      store.insert(job);
    }
  }
  std::multiset<State> open;
  for (const auto& job : store.open_jobs()) open.insert(job.state);
  CHECK(open == std::multiset<State>{State::received, State::received, State::done, State::failed,
                                     State::interrupted, State::interrupted, State::cancelled});
}

TEST_CASE("a transaction that is not committed leaves nothing") {
  TempDir dir;
  JobStore store(dir / "db");
  {
    auto change = store.begin();
    Job job = some_job("a.stl", 1);
    store.insert(job);
  }
  CHECK(store.open_jobs().empty());
  auto change = store.begin();  // and the next one can begin
  change.commit();
}

TEST_CASE("killed at any moment, what was committed is there, whole and once") {
  TempDir dir;
  int rounds = 0;
  for (const int steps : {1, 2, 3, 8, 21, 50}) {
    const auto file = dir / ("db" + std::to_string(steps));
    int ends[2];
    REQUIRE(::pipe(ends) == 0);
    const pid_t child = ::fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      ::close(ends[0]);
      work_until_killed(file, ends[1]);
    }
    ::close(ends[1]);
    std::string told;
    char c = 0;
    while (static_cast<int>(told.size()) < steps && ::read(ends[0], &c, 1) == 1) told += c;
    ::kill(child, SIGKILL);  // wherever it is by now
    while (::read(ends[0], &c, 1) == 1) told += c;
    ::close(ends[0]);
    int status = 0;
    ::waitpid(child, &status, 0);
    REQUIRE(WIFSIGNALED(status));

    JobStore store(file);
    const auto jobs = store.open_jobs();
    const auto inserted = static_cast<std::size_t>(std::count(told.begin(), told.end(), 'i'));
    const auto heated = static_cast<std::size_t>(std::count(told.begin(), told.end(), 'h'));
    CHECK(jobs.size() >= inserted);
    CHECK(jobs.size() <= inserted + 1);
    std::size_t heating = 0;
    std::set<std::uint64_t> inodes;
    for (const auto& job : jobs) {
      inodes.insert(job.file.inode);
      const auto record = store.last_record_of(job.id);
      CHECK((job.state == State::heating) == record.has_value());  // both or neither
      heating += job.state == State::heating ? 1 : 0;
    }
    CHECK(inodes.size() == jobs.size());
    CHECK(heating >= heated);
    CHECK(heating <= heated + 1);
    ++rounds;
  }
  CHECK(rounds == 6);
}

TEST_CASE("history keeps what was measured, unknown layers as unknown") {
  TempDir dir;
  JobStore store(dir / "db");
  PrintRecord record;
  record.job = 5;
  record.file = "a.stl";
  record.started = "2026-01-01T00:00:00Z";
  record.facts = some_facts();
  store.open_record(record);
  CHECK(store.history().empty());  // it has not ended
  REQUIRE(store.last_record_of(5));
  CHECK(store.last_record_of(5)->state == "open");
  record.state = "done";
  record.measured_s = 1250.25;
  record.doubts = 3;
  record.layer_measured_s = {600.5, std::numeric_limits<double>::quiet_NaN()};
  store.close_record(record);
  const auto history = store.history();
  REQUIRE(history.size() == 1);
  CHECK(history[0].measured_s == 1250.25);
  CHECK(history[0].doubts == 3);
  CHECK_FALSE(history[0].total_s);
  REQUIRE(history[0].layer_measured_s.size() == 2);
  CHECK(history[0].layer_measured_s[0] == 600.5);
  CHECK(std::isnan(history[0].layer_measured_s[1]));
}

TEST_CASE("a database from before doubts were counted keeps its prints, which have none") {
  TempDir dir;
  PrintRecord record;
  record.job = 5;
  {
    JobStore store(dir / "db");
    store.open_record(record);
  }
  {
    Database before(dir / "db");
    before.execute("ALTER TABLE prints DROP COLUMN doubts");
    before.execute("PRAGMA user_version=1");
  }
  JobStore store(dir / "db");
  REQUIRE(store.last_record_of(5));
  CHECK(store.last_record_of(5)->doubts == 0);
  record.doubts = 2;
  store.close_record(record);
  CHECK(store.last_record_of(5)->doubts == 2);
}

TEST_CASE("observations are those of the same printer, settings and firmware") {
  TempDir dir;
  JobStore store(dir / "db");
  for (int i = 0; i < 4; ++i) {
    auto record = done(100 + i, 110 + i);
    store.close_record(record);
  }
  auto other = done(100, 300, "other");
  store.close_record(other);
  auto failed = done(100, 300);
  failed.state = "failed";
  store.close_record(failed);
  CHECK(store.observations("left", "p", "f").size() == 4);
  CHECK(store.observations("left", "p", "f", 2).front().predicted_s == 103);
  CHECK(store.observations("right", "p", "f").empty());
  const auto learned = store.learned();
  REQUIRE(learned.size() == 2);
  CHECK(learned[0].profile_sha256 == "other");
  CHECK_FALSE(learned[0].correction);
  REQUIRE(learned[1].correction);
  CHECK(learned[1].correction->factor == Approx(1.1).epsilon(0.01));
}

TEST_CASE("the bed is not clear for a printer nobody has said anything about") {
  TempDir dir;
  JobStore store(dir / "db");
  CHECK_FALSE(store.printer("left").known);
  CHECK_FALSE(store.printer("left").bed_clear);
  store.save_printer("left", {true, true, "stop", "f"});
  const auto memory = store.printer("left");
  CHECK(memory.known);
  CHECK(memory.bed_clear);
  CHECK(memory.held == "stop");
  CHECK(memory.firmware == "f");
}

TEST_CASE("events are kept in order and can be read on from any of them") {
  TempDir dir;
  JobStore store(dir / "db");
  for (int i = 0; i < 10; ++i) store.log("t", "info", "event=" + std::to_string(i));
  const auto last = store.events(0, 3);
  REQUIRE(last.size() == 3);
  CHECK(last[0].text == "event=7");
  CHECK(last[2].text == "event=9");
  CHECK(store.events(last[1].id, 100).size() == 1);
}

TEST_CASE("a file that is no database is refused by name") {
  TempDir dir;
  const auto file = dir.write("db", std::string(4096, 'x'));
  CHECK_THROWS_WITH(JobStore(file), Catch::Contains("db"));
}

TEST_CASE("a printer's limits come back as they were said, and go when forgotten") {
  TempDir dir;
  KeptLimits kept;
  kept.wiring = "/dev/ttyACM0\nprusa-mk3";
  kept.machine = "Marlin 2.1.2\nEnder\n";
  kept.limits.steps_per_mm = {80, 80.1234567890123, std::nullopt, 93};
  kept.limits.jerk_mm_s[2] = 0.4;
  kept.limits.junction_deviation_mm = 0.013;
  kept.limits.min_segment_time_s = 0.02;
  kept.limits.line_form = voidpath::fw::LineForm::packed;
  kept.limits.volume = voidpath::fw::MachineBox{{-1, 0, 0}, {220, 220, 250.5}};
  {
    JobStore store(dir / "db");
    CHECK_FALSE(store.limits("left"));
    store.save_limits("left", kept);
  }
  JobStore store(dir / "db");
  const auto back = store.limits("left");
  REQUIRE(back);
  CHECK(back->wiring == kept.wiring);
  CHECK(back->machine == kept.machine);
  CHECK(back->limits == kept.limits);
  CHECK_FALSE(store.limits("right"));
  // Nothing said is nothing kept.
  store.save_limits("left", {"a", "b", {}});
  CHECK(store.limits("left")->limits == voidpath::fw::FirmwareLimits{});
  store.forget_limits("left");
  CHECK_FALSE(store.limits("left"));
}
