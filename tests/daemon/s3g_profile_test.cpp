#include "daemon/jobs/s3g_machine.h"
#include "engine/mesh/write.h"
#include "engine/pipeline/prepare.h"
#include "firmware-io/printer_port.h"
#include "firmware-io/s3g/encoder.h"
#include "tests/daemon/temp_dir.h"
#include "tests/support/meshes.h"

#include <algorithm>
#include <set>
#include <sstream>
#include <vector>

#include <catch2/catch.hpp>

using namespace voidpath;

namespace {

constexpr const char* kMakerBots[] = {"makerbot-replicator", "makerbot-replicator-single",
                                      "makerbot-replicator-2", "makerbot-replicator-2x"};

}  // namespace

TEST_CASE("what is sliced for a MakerBot can be sent to it, every line") {
  const test::TempDir dir;
  mesh::write_model(test::box(20, 10, 2), dir / "box.stl");
  for (const std::string printer : kMakerBots) {
    for (const std::string material : {"pla", "petg", "abs"}) {
      INFO(printer << ", " << material);
      const config::Profile profile = config::load_profile(printer, material, "0.28mm");
      pipeline::PrepareOptions options;
      options.print = profile.print;
      options.limits = profile.limits;
      options.orient.method = orient::Method::as_delivered;
      options.now_s = [] { return 0.0; };
      const auto gcode = dir / "box.gcode";
      const auto prepared = pipeline::prepare(dir / "box.stl", gcode, options, false, {});
      CHECK(prepared.estimate.predicted_s > 10);
      fw::s3g::Encoder encoder(daemon::s3g_machine(profile));
      const auto source = fw::open_gcode_file(gcode.string());
      std::size_t moves = 0, ends = 0;
      std::vector<int> percents;
      while (const auto line = source->next()) {
        for (const auto& action : encoder.encode(line->text).actions) {
          moves += action.kind == fw::s3g::Action::Kind::move ? 1U : 0U;
          ends += static_cast<unsigned char>(action.payload[0]) == 154 ? 1U : 0U;
          if (static_cast<unsigned char>(action.payload[0]) == 150) percents.push_back(action.payload[1]);
        }
      }
      CHECK(moves > 20);
      CHECK(ends == 1);
      CHECK(std::is_sorted(percents.begin(), percents.end()));
      CHECK(std::set<int>(percents.begin(), percents.end()).size() > 10);  // the panel's bar moves
      CHECK_FALSE(encoder.build_started());
    }
  }
}

TEST_CASE("no motor of a MakerBot moves with the lesser current that a print left while it heated") {
  for (const std::string printer : kMakerBots) {
    INFO(printer);
    const config::Profile profile = config::load_profile(printer, "pla", "0.28mm");
    const auto least_moved_with = [&](const std::vector<std::string>& lines) {
      fw::s3g::Encoder encoder(daemon::s3g_machine(profile));
      encoder.set_stand({});
      int current = 20, least = 127;
      for (const std::string& line : lines) {
        for (const auto& action : encoder.encode(line).actions) {
          const auto code = static_cast<fw::s3g::Command>(static_cast<unsigned char>(action.payload[0]));
          if (code == fw::s3g::Command::pot) current = action.payload[2];
          const bool homes = action.kind == fw::s3g::Action::Kind::home;
          if (homes || action.kind == fw::s3g::Action::Kind::move) least = std::min(least, current);
        }
      }
      return least;
    };
    std::vector<std::string> start;
    std::istringstream text(profile.print.machine.start_gcode);
    for (std::string line; std::getline(text, line);)
      if (line.find('{') == std::string::npos) start.push_back(line);
    CHECK(start.size() > 10);
    CHECK(least_moved_with(start) >= 118);
    CHECK(profile.cancel_gcode.size() > 3);
    CHECK(least_moved_with(profile.cancel_gcode) >= 118);
  }
}
