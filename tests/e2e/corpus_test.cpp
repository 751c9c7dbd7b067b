#include "tests/e2e/bench_rig.h"
#include "tests/support/meshes.h"
#include "tests/support/real_models.h"

#include <catch2/catch.hpp>
#include <sys/resource.h>

using namespace voidpath::test;
namespace fs = std::filesystem;

namespace {

/// Children inherit it: no file may take more than a gigabyte.
void limit_memory() {
  rlimit limit{};
  ::getrlimit(RLIMIT_AS, &limit);
  limit.rlim_cur = rlim_t{1} << 30;
  ::setrlimit(RLIMIT_AS, &limit);
}

bool skipped(const std::string& folder) {
  if (!shared_dir().empty() && fs::exists(fs::path(shared_dir()) / folder / "MANIFEST.csv")) return false;
  WARN("VOIDPATH_SHARED is not set: " + folder + " skipped");
  return true;
}

// A hang, on any machine that runs this.
constexpr double kHang_s = 120;

}  // namespace

TEST_CASE("every real model is oriented by the published method and sliced", "[corpus]") {
  if (skipped("models")) return;
  limit_memory();
  const fs::path folder = fs::path(shared_dir()) / "models";
  const ScratchDir dir;
  std::size_t sliced = 0;
  for (const Row& row : read_csv(folder / "MANIFEST.csv")) {
    const fs::path file = folder / row.at("file");
    if (file.extension() == ".amf") continue;
    INFO(file);
    const Result oriented =
        run({program("voidpath"), "orient", file, "--scale", row.at("scale"), "--method", "thesis", "--json"},
            dir.path(), kHang_s);
    INFO(oriented.err);
    CHECK(oriented.code == 0);
    if (oriented.code == 0) CHECK(nlohmann::json::parse(oriented.out).at("candidates") == 1286);
    const Result out = run({program("voidpath"), "slice", file, "--scale", row.at("scale"), "--as-delivered",
                            "-o", dir / "out.gcode", "--json"},
                           dir.path(), kHang_s);
    INFO(out.err);
    CHECK(out.code == 0);
    if (out.code != 0) continue;
    const auto j = nlohmann::json::parse(out.out);
    CHECK(j.at("predicted_s").get<double>() > 0);
    CHECK(j.at("filament_mm").get<double>() > 0);
    ++sliced;
  }
  CHECK(sliced >= 70);
}

TEST_CASE("every damaged model is printed, repaired or refused with a sentence", "[corpus]") {
  if (skipped("bad-models")) return;
  limit_memory();
  const fs::path folder = fs::path(shared_dir()) / "bad-models";
  const ScratchDir dir;
  std::size_t seen = 0;
  for (const Row& row : read_csv(folder / "MANIFEST.csv")) {
    const fs::path file = folder / row.at("file");
    const std::string& expected = row.at("expected");
    const Result out = run({program("voidpath"), "slice", file, "-o", dir / "out.gcode", "--budget-s", "0",
                            "--subdivisions", "1"},
                           dir.path(), kHang_s);
    INFO(file << " should " << expected << ", ended with " << out.code << ": " << out.err);
    const bool may_refuse = expected.find("reject") != std::string::npos;
    const bool may_print = expected != "reject";
    CHECK(((out.code == 0 && may_print) || (out.code == 3 && may_refuse)));
    CHECK((out.code == 0 || out.err.size() > 40));
    CHECK((out.code == 0) == fs::exists(dir / "out.gcode"));
    fs::remove(dir / "out.gcode");
    ++seen;
  }
  CHECK(seen >= 80);
}
