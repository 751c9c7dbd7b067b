#include <cstdio>
#include <iostream>

#include <nlohmann/json.hpp>

#include "daemon/cli/flags.h"
#include "daemon/cli/offline.h"

namespace voidpath::cli {

namespace {

int list(const CommonFlags& common) {
  nlohmann::ordered_json j = nlohmann::ordered_json::array();
  for (const auto& e : config::list_profiles()) {
    if (common.json)
      j.push_back({{"kind", e.kind}, {"name", e.name}, {"file", e.file.lexically_normal().string()}});
    else
      std::printf("%-9s %-24s %s\n", e.kind.c_str(), e.name.c_str(), e.file.lexically_normal().c_str());
  }
  if (common.json) std::cout << nlohmann::ordered_json{{"profiles", j}}.dump(2) << '\n';
  return 0;
}

/// A printer alone is shown with the default material and quality laid over it.
int show(const CommonFlags& common, const std::string& name) {
  const config::Profile p = config::load_profile(name, pairs_from(common.set));
  std::printf("# %s, %s, %s\n# sha256 %s\n%s", p.printer.c_str(), p.material.c_str(), p.quality.c_str(),
              p.sha256.c_str(), config::profile_text(p).c_str());
  return 0;
}

}  // namespace

int profile_command(const std::vector<std::string>& args) {
  CLI::App app("Lists and shows profiles", "profile");
  CommonFlags common;
  std::string name;
  app.require_subcommand(1);
  auto* list_app = app.add_subcommand("list", "every profile that can be named");
  auto* show_app = app.add_subcommand("show", "PRINTER[,MATERIAL[,QUALITY]] with everything resolved");
  show_app->add_option("name", name, "PRINTER[,MATERIAL[,QUALITY]]")->required();
  add_common(*list_app, common);
  add_common(*show_app, common);
  if (!parse(app, args)) return 0;
  return list_app->parsed() ? list(common) : show(common, name);
}

}  // namespace voidpath::cli
