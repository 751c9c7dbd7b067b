#include "daemon/cli/corpus.h"

#include "daemon/cli/offline.h"
#include "tests/daemon/temp_dir.h"

#include <catch2/catch.hpp>

using namespace voidpath;

TEST_CASE("a folder's models come by name, with the scales of its manifest") {
  const test::TempDir dir;
  for (const char* name : {"b.stl", "a.OBJ", "c.3mf", "notes.txt"}) dir.write(name, "x");
  dir.write("deeper/d.stl", "x");
  auto models = cli::list_corpus(dir.path());
  REQUIRE(models.size() == 3);
  CHECK(models[0].name == "a.OBJ");
  CHECK(models[1].name == "b.stl");
  CHECK(models[2].file == dir / "c.3mf");
  CHECK(models[1].scale == 1);
  dir.write("MANIFEST.csv",
            "licence,file,scale\n\"MIT, or so\",b.stl,2.5\nMIT,c.3mf,\nMIT,elsewhere.amf,3\n");
  models = cli::list_corpus(dir.path());
  REQUIRE(models.size() == 3);
  CHECK(models[1].scale == 2.5);
  CHECK(models[2].scale == 1);
}

TEST_CASE("a manifest lists what it lists, relative to itself") {
  const test::TempDir dir;
  const auto csv = dir.write("lists/some.csv", "scale,file\r\n0.5,../parts/a.stl\r\n,/abs/b.stl\r\n");
  const auto models = cli::list_corpus(csv);
  REQUIRE(models.size() == 2);
  CHECK(models[0].file == dir / "lists/../parts/a.stl");
  CHECK(models[0].scale == 0.5);
  CHECK(models[1].file == "/abs/b.stl");
  CHECK(models[1].name == "/abs/b.stl");
}

TEST_CASE("a corpus that is none is refused by file and line") {
  const test::TempDir dir;
  const auto refused = [&](const std::string& text, const std::string& words) {
    const auto csv = dir.write("m.csv", text);
    CAPTURE(text);
    CHECK_THROWS_WITH(cli::list_corpus(csv), Catch::Contains(words));
    CHECK_THROWS_AS(cli::list_corpus(csv), cli::UsageError);
  };
  refused("", "m.csv:1: is empty");
  refused("name,scale\na.stl,1\n", "m.csv:1: there is no column 'file'");
  refused("file,scale\na.stl,1\n,2\n", "m.csv:3: no file is named");
  refused("file,scale\na.stl,big\n", "m.csv:2: scale: ");
  refused("file,scale\na.stl,-1\n", "m.csv:2: scale -1: a positive number");
  refused("file\n", "holds no models");
  CHECK_THROWS_WITH(cli::list_corpus(dir / "missing"), Catch::Contains("there is no such folder or file"));
}
