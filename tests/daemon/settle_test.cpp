#include "daemon/intake/settle.h"

#include "tests/daemon/temp_dir.h"

#include <map>

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <unistd.h>

using namespace voidpath::daemon;
namespace fs = std::filesystem;

namespace {

/// Files that exist only here.
struct FakeFiles {
  struct File {
    FileId id;
    bool writer = false;
    Completeness state = Completeness::complete;
  };
  std::map<fs::path, File> files;

  FileProbe probe() {
    return {[this](const fs::path& path) -> std::optional<FileId> {
              const auto found = files.find(path);
              return found == files.end() ? std::nullopt : std::optional(found->second.id);
            },
            [this](const fs::path& path) { return files.at(path).writer; },
            [this](const fs::path& path) { return files.at(path).state; }};
  }
};

FileId sized(std::uint64_t size) { return {1, 2, size, 3}; }

std::string binary_stl(std::uint32_t promised, std::size_t held) {
  std::string out(80, ' ');
  out.append(reinterpret_cast<const char*>(&promised), 4);
  out.append(held * 50, '\0');
  return out;
}

}  // namespace

TEST_CASE("a file counts once it has not changed for the settling time") {
  FakeFiles fake;
  fake.files["a.stl"].id = sized(100);
  Settler settler(1.0, fake.probe());
  settler.note("a.stl", 10.0);
  CHECK(settler.poll(10.5).empty());
  fake.files["a.stl"].id = sized(200);  // grew without a word
  CHECK(settler.poll(11.2).empty());
  CHECK(settler.poll(12.1).empty());
  const auto out = settler.poll(12.3);
  REQUIRE(out.size() == 1);
  CHECK(out[0].path == "a.stl");
  CHECK(out[0].id == sized(200));
  CHECK(settler.idle());
}

TEST_CASE("a file in a writer's hands is never taken, however long it rests") {
  FakeFiles fake;
  fake.files["a.stl"] = {sized(100), true, Completeness::unknown};
  Settler settler(1.0, fake.probe());
  settler.note("a.stl", 0);
  for (double now = 0; now < 600; now += 0.5) REQUIRE(settler.poll(now).empty());
  fake.files["a.stl"].writer = false;
  settler.note("a.stl", 600.1);  // closed
  CHECK(settler.poll(601.0).empty());
  CHECK(settler.poll(601.2).size() == 1);
}

TEST_CASE("a file that says that it is not complete is waited for, then taken") {
  FakeFiles fake;
  fake.files["a.stl"] = {sized(100), false, Completeness::truncated};
  fake.files["b.gcode"] = {sized(100), false, Completeness::truncated};
  Settler settler(1.0, fake.probe());
  settler.note("a.stl", 0);
  settler.note("b.gcode", 0);
  CHECK(settler.poll(kUnendedPatience_s - 1).empty());
  const auto text = settler.poll(kUnendedPatience_s + 1);
  REQUIRE(text.size() == 1);
  CHECK(text[0].path == "b.gcode");
  CHECK(settler.poll(kTruncatedPatience_s - 1).empty());
  CHECK(settler.poll(kTruncatedPatience_s + 1).size() == 1);
}

TEST_CASE("a half copy that goes on after a pause is taken whole") {
  FakeFiles fake;
  fake.files["a.stl"] = {sized(100), false, Completeness::truncated};
  Settler settler(1.0, fake.probe());
  settler.note("a.stl", 0);
  for (double now = 0; now < 60; now += 1) REQUIRE(settler.poll(now).empty());
  fake.files["a.stl"] = {sized(200), false, Completeness::complete};
  CHECK(settler.poll(60).empty());
  const auto out = settler.poll(61.5);
  REQUIRE(out.size() == 1);
  CHECK(out[0].id.size == 200);
}

TEST_CASE("files come in the order in which they were first noted; vanished ones do not come") {
  FakeFiles fake;
  for (const char* name : {"c.stl", "a.stl", "b.stl"}) fake.files[name].id = sized(1);
  Settler settler(1.0, fake.probe());
  settler.note("c.stl", 0);
  settler.note("a.stl", 0.1);
  settler.note("b.stl", 0.2);
  settler.note("c.stl", 0.3);
  CHECK(settler.pending("a.stl"));
  fake.files.erase("a.stl");
  const auto out = settler.poll(2);
  REQUIRE(out.size() == 2);
  CHECK(out[0].path == "c.stl");
  CHECK(out[1].path == "b.stl");
  CHECK_FALSE(settler.pending("a.stl"));
}

TEST_CASE("a writer is seen on a real file, and so is that it went away") {
  voidpath::test::TempDir dir;
  const auto file = dir.write("a.stl", "solid\n");
  CHECK_FALSE(open_for_writing(file));
  const int reader = ::open(file.c_str(), O_RDONLY);
  CHECK_FALSE(open_for_writing(file));
  const int writer = ::open(file.c_str(), O_WRONLY | O_APPEND);
  REQUIRE(writer >= 0);
  CHECK(open_for_writing(file));
  ::close(writer);
  ::close(reader);
  CHECK_FALSE(open_for_writing(file));
  CHECK_FALSE(open_for_writing(dir / "none.stl"));
}

TEST_CASE("names tell inputs from what is not finished or not ours") {
  for (const char* name : {"a.stl", "A.STL", "b c.obj", "d.3mf", "ü.stl"})
    CHECK(input_kind(name) == InputKind::model);
  for (const char* name : {"a.gcode", "a.GCO", "a.g", "a.gx"}) CHECK(input_kind(name) == InputKind::gcode);
  for (const char* name : {".a.stl", "~a.stl", "a.stl~", "a.stl.part", "a.stl.crdownload", "a.txt", "stl",
                           "#a.stl", ".voidpath.yaml", "a.voidpath.yaml", "a.stl.report.json"}) {
    CHECK(input_kind(name) == InputKind::none);
  }
}

TEST_CASE("content tells whether a file is complete") {
  voidpath::test::TempDir dir;
  const auto judge = [&](const std::string& name, const std::string& text) {
    return completeness(dir.write(name, text));
  };
  CHECK(judge("a.stl", binary_stl(10, 10)) == Completeness::complete);
  CHECK(judge("a.stl", binary_stl(10, 4)) == Completeness::truncated);
  CHECK(judge("a.stl", binary_stl(10, 10) + "extra") == Completeness::unknown);
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
  CHECK(judge("b.stl", "solid x\n" + facet + facet + "endsolid x\n") == Completeness::complete);
  CHECK(judge("b.stl", "solid x\n" + facet + facet.substr(0, 30)) == Completeness::truncated);
  CHECK(judge("c.3mf", "PK\x03\x04 half an archive") == Completeness::truncated);
  CHECK(judge("c.3mf", std::string("PK\x03\x04 data PK\x05\x06") + std::string(18, '\0')) ==
        Completeness::complete);
  CHECK(judge("d.gcode", "G28\nG1 X1\n") == Completeness::unknown);
  CHECK(judge("d.gcode", "G28\nG1 X") == Completeness::truncated);
  CHECK(judge("e.obj", "v 0 0 0\nv 1") == Completeness::truncated);
  CHECK(judge("f.stl", "") == Completeness::truncated);
  // Neither kind of STL: not for waiting, but for refusing.
  CHECK(judge("g.stl", "<html>not a model</html>") == Completeness::unknown);
  CHECK(judge("g.stl", std::string(3000, 'x')) == Completeness::unknown);
}
