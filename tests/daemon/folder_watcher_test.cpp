#include "daemon/intake/folder_watcher.h"

#include "tests/daemon/temp_dir.h"

#include <algorithm>

#include <catch2/catch.hpp>
#include <poll.h>
#include <unistd.h>

using voidpath::daemon::FolderWatcher;
using voidpath::test::TempDir;
namespace fs = std::filesystem;

namespace {

struct Watched {
  explicit Watched(const TempDir& dir, const std::string& name = "inbox")
      : watcher(
            {dir / name}, [this](const fs::path& file) { found.push_back(file.filename().string()); },
            [this](const fs::path&, const std::string& what) { trouble.push_back(what); }) {
    watcher.check();
  }
  /// Takes the events that are there by now: the kernel queues them before the call that causes them returns.
  std::vector<std::string> take() {
    found.clear();
    pollfd poll{watcher.fd(), POLLIN, 0};
    while (::poll(&poll, 1, 0) > 0) watcher.on_readable();
    auto out = found;
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }
  std::vector<std::string> found, trouble;
  FolderWatcher watcher;
};

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("files already there are found at start, oldest first, only candidates") {
  TempDir dir;
  const auto b = dir.write("inbox/b.stl", "x");
  const auto a = dir.write("inbox/a.stl", "x");
  fs::last_write_time(b, fs::last_write_time(a) - std::chrono::seconds(10));
  dir.write("inbox/.hidden.stl", "x");
  dir.write("inbox/notes.txt", "x");
  dir.write("inbox/done/old.stl", "x");
  fs::create_directories(dir / "inbox/folder.stl");
  Watched w(dir);
  CHECK(w.found == Names{"b.stl", "a.stl"});
}

TEST_CASE("files written, moved in and linked in are found; hidden ones and subfolders are not") {
  TempDir dir;
  fs::create_directories(dir / "inbox");
  Watched w(dir);
  dir.write("inbox/a.stl", "x");
  CHECK(w.take() == Names{"a.stl"});
  dir.write("else/b.stl", "x");
  fs::rename(dir / "else/b.stl", dir / "inbox/b.stl");
  CHECK(w.take() == Names{"b.stl"});
  dir.write("else/c.gcode", "x");
  fs::create_hard_link(dir / "else/c.gcode", dir / "inbox/c.gcode");
  CHECK(w.take() == Names{"c.gcode"});
  dir.write("inbox/.d.stl.part", "x");
  dir.write("inbox/done/e.stl", "x");
  dir.write("inbox/failed/f.stl", "x");
  CHECK(w.take() == Names{});
  fs::rename(dir / "inbox/.d.stl.part", dir / "inbox/d.stl");  // as a careful program does it
  CHECK(w.take() == Names{"d.stl"});
}

TEST_CASE("a missing folder is made; a recreated one is taken up with what is in it") {
  TempDir dir;
  Watched w(dir, "new/inbox");
  CHECK(fs::is_directory(dir / "new/inbox"));
  dir.write("new/inbox/a.stl", "x");
  CHECK(w.take() == Names{"a.stl"});

  fs::rename(dir / "new/inbox", dir / "away");
  dir.write("new/inbox/b.stl", "x");
  dir.write("away/stranger.stl", "x");
  auto found = w.take();
  CHECK(std::count(found.begin(), found.end(), "b.stl") == 1);
  CHECK(std::count(found.begin(), found.end(), "stranger.stl") == 0);
  fs::remove_all(dir / "new/inbox");
  w.take();
  w.watcher.check();
  dir.write("new/inbox/c.stl", "x");
  found = w.take();
  CHECK(std::count(found.begin(), found.end(), "c.stl") == 1);
}

TEST_CASE("a folder that cannot be watched is told of once, and again when it can") {
  TempDir dir;
  dir.write("inbox", "a file stands in its way");
  Watched w(dir);
  w.watcher.check();
  REQUIRE(w.trouble.size() == 1);
  fs::remove(dir / "inbox");
  w.watcher.check();
  CHECK(w.trouble.size() == 2);
  dir.write("inbox/a.stl", "x");
  CHECK(w.take() == Names{"a.stl"});
}

TEST_CASE("everything can be looked at anew") {
  TempDir dir;
  dir.write("inbox/a.stl", "x");
  Watched w(dir);
  w.found.clear();
  w.watcher.scan_all();
  CHECK(w.found == Names{"a.stl"});
}
