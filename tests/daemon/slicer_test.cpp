#include "daemon/jobs/prepare_worker.h"
#include "daemon/slicer/cura_settings.h"
#include "daemon/slicer/foreign.h"
#include "daemon/slicer/program.h"
#include "engine/gcode/walk.h"
#include "engine/mesh/import.h"
#include "engine/mesh/write.h"
#include "tests/daemon/temp_dir.h"
#include "tests/support/meshes.h"

#include <chrono>
#include <cstdlib>
#include <thread>

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace voidpath;
using namespace voidpath::daemon;
namespace fs = std::filesystem;

namespace {

/// Stands for PrusaSlicer: takes its arguments and writes a square of that size around the wanted centre.
const char* const kSquare = R"(#!/bin/sh
centre=110,110; out=; half=9.8
while [ $# -gt 0 ]; do
  case "$1" in
    --center) centre=$2; shift ;;
    --output) out=$2; shift ;;
    --load) profile=$2; shift ;;
  esac
  model=$1
  shift
done
grep -q '^layer_height' "$profile" || { echo "no layer height" >&2; exit 5; }
[ -s "$model" ] || exit 6
x=${centre%,*}; y=${centre#*,}
echo "10 => Processing triangulated mesh"
echo "a warning about nothing"
awk -v x="$x" -v y="$y" -v h="$half" 'BEGIN {
  print "G28\nM83\nG1 X-3 Y-3 Z0.3 F3000\nG1 X60 E9\n;LAYER_CHANGE\n;Z:0.2\nG1 Z0.2"
  print ";TYPE:External perimeter"
  printf "G1 X%g Y%g F6000\n", x-h, y-h
  printf "G1 X%g Y%g E1 F1200\nG1 X%g Y%g E1\nG1 X%g Y%g E1\nG1 X%g Y%g E1\n", x+h,y-h, x+h,y+h, x-h,y+h, x-h,y-h
}' > "$out"
)";

struct Bench {
  test::TempDir dir;
  config::SlicerConfig slicer;

  explicit Bench(const std::string& script) {
    slicer.name = config::kPrusaSlicer;
    slicer.prusa_slicer.program = dir.write("fake slicer", script);
    fs::permissions(slicer.prusa_slicer.program, fs::perms::owner_all);
    slicer.prusa_slicer.profile = dir.write("my profile.ini", "layer_height = 0.2\nbinary_gcode = 1\n");
    mesh::write_model(test::box(20, 20, 10), dir / "cube.stl");
  }
  PrepareResult prepare(const run::Context& ctx = {}, const std::string& named = "") const {
    PrepareTask task;
    task.input = dir / "cube.stl";
    task.file = *identify(task.input);
    task.options.method = "as-delivered";
    task.options.slicer = named;
    task.folder = dir.path();
    task.gcode_out = dir / "state/1/print.gcode";
    task.printer.profile = "generic-marlin";
    task.slicer = slicer;
    return prepare_input(task, ctx);
  }
  std::string failure() const {
    const PrepareResult result = prepare();
    REQUIRE(result.kind == PrepareResult::Kind::failed);
    CHECK_FALSE(fs::exists(dir / "state/1"));
    CHECK(fs::exists(dir / "cube.stl"));
    return result.message;
  }
};

std::string square(const std::string& from, const std::string& to) {
  std::string script = kSquare;
  for (std::size_t at = 0; (at = script.find(from, at)) != std::string::npos; at += to.size())
    script.replace(at, from.size(), to);
  return script;
}

/// Gone, or a zombie that only its parent's wait keeps.
bool gone(pid_t pid) {
  for (int i = 0; i < 1000; ++i) {
    if (::kill(pid, 0) != 0) return true;
    std::ifstream in("/proc/" + std::to_string(pid) + "/stat");
    std::string text((std::istreambuf_iterator<char>(in)), {});
    if (text.find(") Z") != std::string::npos) return true;
    std::this_thread::yield();
    ::poll(nullptr, 0, 10);
  }
  return false;
}

pid_t pid_in(const fs::path& file) {
  for (int i = 0; i < 1000; ++i) {
    std::ifstream in(file);
    pid_t pid = 0;
    if (in >> pid && pid > 0) return pid;
    ::poll(nullptr, 0, 10);
  }
  return 0;
}

}  // namespace

TEST_CASE("an installed slicer makes the print, and our planner times what it made") {
  const Bench bench(kSquare);
  const PrepareResult result = bench.prepare();
  INFO(result.message);
  REQUIRE(result.kind == PrepareResult::Kind::prepared);
  CHECK(result.facts.layers == 1);
  CHECK(result.facts.filament_mm == Approx(13));
  // Four sides of 19.6 mm at 20 mm/s, and the way there.
  CHECK(result.facts.predicted_s > 4 * 19.6 / 20);
  REQUIRE(result.slicer_messages.size() == 1);
  CHECK(result.slicer_messages[0] == "prusa-slicer: a warning about nothing");
  CHECK(result.facts.notes.back() == result.slicer_messages[0]);
  // Nothing is left of the slicer's own folder.
  CHECK(std::distance(fs::directory_iterator(bench.dir / "state/1"), {}) == 1);
  const auto printed = gcode::printed_extents(bench.dir / "state/1/print.gcode");
  CHECK(printed.all.min[0] == Approx(110 - 9.8));
  CHECK(printed.outer_walls.max[1] == Approx(110 + 9.8));
  // Another profile, other prints to learn from; and the built-in slicer when the job wants it.
  const PrepareResult own = bench.prepare({}, config::kBuiltinSlicer);
  CHECK(own.facts.layers == 50);
  CHECK(own.facts.profile_sha256 != result.facts.profile_sha256);
  bench.dir.write("my profile.ini", "layer_height = 0.3\n");
  CHECK(bench.prepare().facts.profile_sha256 != result.facts.profile_sha256);
}

TEST_CASE("what goes wrong with an installed slicer fails the job in words") {
  CHECK_THAT(Bench("#!/bin/sh\necho 'unknown option zzz' >&2\nexit 3\n").failure(),
             Catch::Contains("failed with code 3") && Catch::Contains("unknown option zzz"));
  CHECK_THAT(Bench("#!/bin/sh\nexit 0\n").failure(),
             Catch::Contains("wrote no G-code") && Catch::Contains("said nothing"));
  CHECK_THAT(Bench("#!/bin/sh\nkill -SEGV $$\n").failure(), Catch::Contains("signal"));
}

TEST_CASE("G-code that prints nothing, elsewhere or outside of the machine is not taken") {
  CHECK_THAT(Bench(square("half=9.8", "half=30")).failure(), Catch::Contains("put the part elsewhere"));
  CHECK_THAT(Bench(square("x=${centre%,*}", "x=150")).failure(), Catch::Contains("put the part elsewhere"));
  CHECK_THAT(Bench(square("x=${centre%,*}", "x=215")).failure(),
             Catch::Contains("the printer reaches x 0 to 220"));
  CHECK_THAT(Bench(square(" E1", " E0")).failure(),
             Catch::Contains("prints nothing"));
}

TEST_CASE("a missing program or profile is told with what to do") {
  Bench bench(kSquare);
  bench.slicer.prusa_slicer.program = "no-such-slicer-anywhere";
  CHECK_THAT(bench.failure(),
             Catch::Contains("no-such-slicer-anywhere") && Catch::Contains("apt install prusa-slicer"));
  bench.slicer.prusa_slicer.program = bench.dir / "fake slicer";
  bench.slicer.prusa_slicer.profile.clear();
  CHECK_THAT(bench.failure(), Catch::Contains("prusa_slicer.profile"));
  bench.slicer.name = config::kCuraEngine;
  bench.slicer.cura_engine.program = bench.dir / "fake slicer";
  CHECK_THAT(bench.failure(), Catch::Contains("cura_engine.definition"));
}

TEST_CASE("a slicer that takes too long is ended") {
  Bench bench("#!/bin/sh\necho begun\nsleep 600\n");
  bench.slicer.prusa_slicer.time_limit_s = 0.3;
  CHECK_THAT(bench.failure(), Catch::Contains("longer than 0.3 s"));
}

TEST_CASE("a cancelled job ends its slicer at once") {
  Bench bench("#!/bin/sh\nsleep 600 &\necho $! > \"$(dirname \"$0\")/child\"\nwait\n");
  std::stop_source stop;
  run::Context ctx;
  ctx.stop = stop.get_token();
  pid_t child = 0;
  std::jthread canceller([&] {
    child = pid_in(bench.dir / "child");
    stop.request_stop();
  });
  const auto began = std::chrono::steady_clock::now();
  CHECK(bench.prepare(ctx).kind == PrepareResult::Kind::stopped);
  CHECK(std::chrono::steady_clock::now() - began < std::chrono::seconds(60));
  canceller.join();
  CHECK(gone(child));
}

TEST_CASE("a slicer does not outlive the daemon, however that dies") {
  const test::TempDir dir;
  const fs::path script = dir.write("stay", "#!/bin/sh\nsleep 600 &\necho $! > child\nwait\n");
  fs::permissions(script, fs::perms::owner_all);
  const pid_t daemon = ::fork();
  REQUIRE(daemon >= 0);
  if (daemon == 0) {
    ProgramCall call;
    call.args = {script};
    call.folder = dir.path();
    call.log = dir / "log";
    call.time_limit_s = 600;
    run_program(call, {});
    ::_exit(0);
  }
  const pid_t child = pid_in(dir / "child");
  CHECK(child > 0);
  ::kill(daemon, SIGKILL);
  ::waitpid(daemon, nullptr, 0);
  CHECK(gone(child));
}

TEST_CASE("a program gets its limits, its folder, its environment and none of our files") {
  const test::TempDir dir;
  const int ours = ::open("/dev/null", O_RDONLY);  // without O_CLOEXEC
  ProgramCall call;
  call.args = {"/bin/sh", "-c", "pwd; echo \"$WORD\"; ls /proc/self/fd | wc -l; ulimit -d; nice; cat"};
  call.environment = {{"WORD", "two words; $HOME"}};
  call.folder = fs::canonical(dir.path());
  call.log = dir / "log";
  call.time_limit_s = 60;
  call.memory_limit_bytes = std::uint64_t{1} << 30;
  const ProgramEnd end = run_program(call, {});
  ::close(ours);
  CHECK(end.kind == ProgramEnd::Kind::exited);
  CHECK(end.code == 0);
  std::istringstream log(test::read_all(dir / "log"));
  std::string pwd, word;
  int files = 0, data_kb = 0, niceness = 0;
  std::getline(log, pwd);
  std::getline(log, word);
  log >> files >> data_kb >> niceness;
  CHECK(pwd == call.folder.string());
  CHECK(word == "two words; $HOME");
  CHECK(files == 4);  // standard ones, and the folder that ls reads
  CHECK(data_kb == 1 << 20);
  CHECK(niceness >= 10);
}

TEST_CASE("a program that cannot be executed is an error with its name") {
  const test::TempDir dir;
  const fs::path file = dir.write("no program", "\x01\x02");
  fs::permissions(file, fs::perms::owner_all);
  ProgramCall call;
  call.args = {file};
  call.folder = dir.path();
  call.log = dir / "log";
  call.time_limit_s = 60;
  CHECK_THROWS_WITH(run_program(call, {}), Catch::Contains("no program"));
}

TEST_CASE("Cura's settings are read from a list and from a profile, formulas refused") {
  const test::TempDir dir;
  const auto plain = read_cura_settings(
      dir.write("a", "# mine\nlayer_height = 0.15\nmachine_end_gcode = M84\\nM117 done\n"));
  CHECK(plain.at("layer_height") == "0.15");
  CHECK(plain.at("machine_end_gcode") == "M84\nM117 done");
  const auto profile =
      read_cura_settings(dir.write("b",
                                   "[general]\nversion = 4\nname = Fine\n\n[values]\nspeed_print = "
                                   "40\nmachine_start_gcode = G28\n\tG1 Z5\n"));
  CHECK(profile.size() == 2);
  CHECK(profile.at("machine_start_gcode") == "G28\nG1 Z5");
  CHECK_THROWS_WITH(read_cura_settings(dir.write("c", "a = 1\nspeed_wall = =speed_print / 2\n")),
                    Catch::Contains("c:2: speed_wall is a formula"));
  CHECK_THROWS_WITH(read_cura_settings(dir.write("d", "what is this\n")), Catch::Contains("d:1"));
}

namespace {

/// The part's box at 0.2 mm layers, upright and placed by ours, sliced by the real program.
void slices_in_place(const config::SlicerConfig& slicer, const std::string& wall) {
  const test::TempDir dir;
  mesh::write_model(test::table(40, 24, 20, 4, 6), dir / "table.stl");
  pipeline::PrepareOptions options;
  const config::Profile profile = config::load_profile("prusa-i3-mk3,pla,0.20mm");
  options.print = profile.print;
  options.limits = profile.limits;
  options.orient = config::search_options({}, profile);
  options.direction = geom::Vec3(0, 0, -1);
  options.slicer = foreign_slicer(slicer, "", {});
  const auto made = pipeline::prepare(dir / "table.stl", dir / "out.gcode", options, false);
  CHECK(made.estimate.layers.size() == 100);
  options.slicer = {};
  const auto ours = pipeline::prepare(dir / "table.stl", dir / "ours.gcode", options, false);
  CHECK(made.estimate.filament_mm == Approx(ours.estimate.filament_mm).epsilon(0.25));
  CHECK(made.estimate.by_feature.contains(wall));
  const auto printed = gcode::printed_extents(dir / "out.gcode");
  const double half[] = {20 - 0.225, 12 - 0.225};
  const double centre[] = {125, 105};
  for (std::size_t a = 0; a < 2; ++a) {
    CHECK(printed.outer_walls.min[a] == Approx(centre[a] - half[a]).margin(0.03));
    CHECK(printed.outer_walls.max[a] == Approx(centre[a] + half[a]).margin(0.03));
  }
  CHECK(printed.outer_walls.max[2] == Approx(20).margin(0.01));
}

}  // namespace

TEST_CASE("the real PrusaSlicer leaves the part where we put it") {
  config::SlicerConfig slicer;
  slicer.name = config::kPrusaSlicer;
  if (find_program(slicer.prusa_slicer.program).empty()) {
    WARN("skipped: PrusaSlicer is not installed");
    return;
  }
  const test::TempDir dir;
  slicer.prusa_slicer.profile = dir.write(
      "p.ini",
      "layer_height = 0.2\nfirst_layer_height = 0.2\nnozzle_diameter = 0.4\nextrusion_width = 0.45\n"
      "external_perimeter_extrusion_width = 0.45\nbed_shape = 0x0,250x0,250x210,0x210\n"
      "max_print_height = 210\ngcode_flavor = marlin2\n");
  slices_in_place(slicer, "External perimeter");
}

TEST_CASE("the real CuraEngine leaves the part where we put it") {
  config::SlicerConfig slicer;
  slicer.name = config::kCuraEngine;
  const char* definition = std::getenv("VOIDPATH_CURA_DEFINITION");
  if (find_program(slicer.cura_engine.program).empty() || definition == nullptr) {
    WARN(
        "skipped: CuraEngine is not installed, or VOIDPATH_CURA_DEFINITION does not name "
        "fdmprinter.def.json");
    return;
  }
  slicer.cura_engine.definition = definition;
  slices_in_place(slicer, "WALL-OUTER");
}
