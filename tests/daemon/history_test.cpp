#include "daemon/jobs/filing.h"
#include "daemon/jobs/report_text.h"
#include "tests/daemon/temp_dir.h"

#include <algorithm>

#include <catch2/catch.hpp>

using namespace voidpath::daemon;

namespace {

std::size_t cells_of(const std::string& line) {
  std::size_t cells = 1;
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (c == ',' && !quoted) ++cells;
  }
  return cells;
}

PrintRecord full() {
  PrintRecord record;
  record.id = 3;
  record.file = "a, \"b\".stl";
  record.started = "2026-01-01T00:00:00Z";
  record.state = "done";
  record.facts.direction = {0, 0, 1};
  record.facts.criteria = voidpath::orient::Criteria{};
  record.measured_s = 5;
  return record;
}

}  // namespace

TEST_CASE("a history row has every promised field, in the promised order, first") {
  const std::vector<std::string> promised = {
      "id",       "file",        "model_sha256",    "started",    "state",         "method",   "direction",
      "criteria", "predicted_s", "predicted_raw_s", "measured_s", "heating_s",     "paused_s", "total_s",
      "layers",   "filament_mm", "printer",         "firmware",   "profile_sha256"};
  for (const auto& record : {full(), PrintRecord{}}) {
    const Json row = Json::parse(history_json(record).dump());
    REQUIRE(row.members().size() >= promised.size());
    for (std::size_t i = 0; i < promised.size(); ++i) CHECK(row.members()[i].key == promised[i]);
  }
  const Json row = history_json(full());
  CHECK(row["direction"].items().size() == 3);
  for (const char* name : {"H_mm", "V_mm3", "C", "D_mm"}) CHECK(row["criteria"][name].is_number());
  CHECK(history_json({})["measured_s"].is_null());
}

TEST_CASE("CSV rows have as many cells as the header, whatever a name contains") {
  const std::string header = history_csv_header();
  CHECK(header.rfind("id,file,model_sha256,started,state,method,dx,dy,dz,H_mm,V_mm3,C,D_mm,predicted_s", 0) ==
        0);
  CHECK(cells_of(history_csv(full())) == cells_of(header));
  CHECK(cells_of(history_csv({})) == cells_of(header));
  CHECK(history_csv(full()).find("\"a, \"\"b\"\".stl\"") != std::string::npos);
}

TEST_CASE("an input that was moved by a run that then ended is found, and reported on once") {
  voidpath::test::TempDir dir;
  Job job;
  job.folder = dir / "inbox";
  job.input = dir.write("inbox/a.stl", "x");
  job.location = job.input;
  job.file = *identify(job.input);
  job.state = State::done;
  std::filesystem::create_directories(dir / "inbox/done");
  std::filesystem::rename(job.input, dir / "inbox/done/a.stl");
  file_input(job, "done", full());
  CHECK(job.location == dir / "inbox/done/a.stl");
  CHECK(std::filesystem::exists(dir / "inbox/done/a.stl.report.json"));
  CHECK_FALSE(std::filesystem::exists(dir / "inbox/done/a-2.stl"));
}

TEST_CASE("reports of a replaced input leave those of the first print alone") {
  voidpath::test::TempDir dir;
  const auto job_of = [&](JobId id) {
    Job job;
    job.id = id;
    job.folder = dir / "inbox";
    job.input = job.location = dir / "inbox/a.stl";
    job.state = State::done;
    return job;
  };
  const auto record_of = [](JobId id) {
    auto record = full();
    record.id = 10 * id;
    record.job = id;
    record.file = "a.stl";
    return record;
  };
  const auto reported = [&](const std::string& name) {
    const auto text = voidpath::test::read_all(dir / ("inbox/done/" + name + ".report.json"));
    return text.empty() ? 0 : Json::parse(text)["job"].integer();
  };
  const auto present = [&](JobId id) {
    dir.write("inbox/a.stl", std::string(static_cast<std::size_t>(id), 'x'));
    Job job = job_of(id);
    job.file = *identify(job.input);
    return job;
  };
  Job first = present(1);
  file_input(first, "done", record_of(1));
  CHECK(first.location == dir / "inbox/done/a.stl");
  Job replaced = job_of(2);  // its file is nowhere any more
  file_input(replaced, "done", record_of(2));
  file_input(replaced, "done", record_of(2));  // a run that ended before it was noted down
  CHECK(reported("a.stl") == 1);
  CHECK(reported("a-2.stl") == 2);
  CHECK(reported("a-3.stl") == 0);
  CHECK(std::filesystem::exists(dir / "inbox/done/a-2.stl.report.txt"));
  Job third = present(3);  // must not take the name whose reports are the second's
  file_input(third, "done", record_of(3));
  CHECK(third.location == dir / "inbox/done/a-3.stl");
  CHECK(reported("a-2.stl") == 2);
  CHECK(reported("a-3.stl") == 3);
  CHECK(name_when_dropped(third.location) == "a.stl");
  CHECK(name_when_dropped(dir / "inbox/other.stl") == "other.stl");
}

TEST_CASE("JSON text survives a round trip, strange characters too") {
  const std::string odd = "tab\t quote\" back\\ line\n ü 😀 \x01";
  Json json = Json::object().set("text", odd).set("whole", std::int64_t{1} << 60).set("real", 0.1);
  json.set("list", Json::array().push(true).push(nullptr).push("x"));
  for (const int indent : {0, 2}) {
    const Json back = Json::parse(json.dump(indent));
    CHECK(back["text"].text() == odd);
    CHECK(back["whole"].integer() == std::int64_t{1} << 60);
    CHECK(back["real"].number() == 0.1);
    REQUIRE(back["list"].items().size() == 3);
    CHECK(back["list"].items()[0].boolean());
    CHECK(back["list"].items()[1].is_null());
  }
  CHECK(Json::parse(Json("bad \xff\xc3 utf").dump()).text() == "bad \xEF\xBF\xBD\xEF\xBF\xBD utf");
  CHECK_THROWS_AS(Json::parse("{\"a\":"), JsonError);
}

TEST_CASE("signs that a damaged line was obeyed stand in the history and, if there are any, in the report") {
  PrintRecord record = full();
  CHECK(report_text({}, record).find("doubts") == std::string::npos);
  record.doubts = 2;
  CHECK(history_json(record)["doubts"].integer() == 2);
  CHECK(report_text({}, record).find("doubts: 2 signs") != std::string::npos);
}
