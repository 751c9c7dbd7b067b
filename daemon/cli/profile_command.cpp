#include "config/prusa/import.h"
#include "daemon/cli/flags.h"
#include "daemon/cli/offline.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>

#include <nlohmann/json.hpp>

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

struct ImportFlags {
  std::string file;
  std::string out;     ///< one complete profile
  std::string folder;  ///< instead: three profiles in the folders of their kinds
  std::string name;    ///< of those; empty: the file's
  std::string base = "generic-marlin";
  config::PresetNames presets;
  bool list = false;
};

int list_presets(const CommonFlags& common, const config::PrusaFile& file) {
  nlohmann::ordered_json j;
  for (const std::string kind : {"printer", "filament", "print"}) {
    j[kind] = config::preset_names(file, kind);
    if (!common.json)
      for (const std::string& name : config::preset_names(file, kind))
        std::printf("%-9s %s\n", kind.c_str(), name.c_str());
  }
  if (common.json) std::cout << j.dump(2) << '\n';
  return 0;
}

void write_file(const std::filesystem::path& file, const std::string& text) {
  std::error_code ec;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), ec);
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out << text;
  out.close();
  if (!out) throw std::runtime_error(file.string() + ": cannot be written");
}

void tell(const char* heading, const std::vector<std::string>& lines) {
  if (lines.empty()) return;
  std::fprintf(stderr, "%s\n", heading);
  for (const std::string& line : lines) std::fprintf(stderr, "  %s\n", line.c_str());
}

/// The profile must load before it is called imported.
int import(const CommonFlags& common, const ImportFlags& flags) {
  const config::PrusaFile file = config::read_prusa_file(flags.file);
  if (flags.list) return list_presets(common, file);
  std::vector<std::string> notes;
  config::PrusaImport made = config::import_prusa(config::choose_presets(file, flags.presets, notes));
  made.notes.insert(made.notes.begin(), notes.begin(), notes.end());
  const std::string source = std::filesystem::path(flags.file).filename().string();
  const std::string description = "imported from PrusaSlicer's " + source;
  std::vector<std::string> written;
  std::string use;
  if (!flags.folder.empty()) {
    const std::string name = flags.name.empty() ? std::filesystem::path(source).stem().string() : flags.name;
    const std::filesystem::path folder = flags.folder;
    for (const auto& [part, kind] :
         {std::pair{"printer", "printers"}, {"material", "materials"}, {"quality", "qualities"}}) {
      const auto target = folder / kind / (name + ".yaml");
      write_file(target, config::profile_yaml(made, part, flags.base, description));
      written.push_back(target.string());
    }
    use = written[0] + "," + written[1] + "," + written[2];
  } else if (!flags.out.empty()) {
    write_file(flags.out, config::profile_yaml(made, "", flags.base, description));
    written.push_back(flags.out);
    use = flags.out.find('/') == std::string::npos && !flags.out.ends_with(".yaml") ? "./" + flags.out
                                                                                    : flags.out;
  } else if (!common.json) {
    std::fputs(config::profile_yaml(made, "", flags.base, description).c_str(), stdout);
  }
  if (!use.empty()) config::load_profile(use);
  if (common.json) {
    nlohmann::ordered_json values;
    for (const auto& [key, value] : made.values) values[key] = value;
    const nlohmann::ordered_json j = {{"files", written},          {"base", flags.base},
                                      {"values", values},          {"approximated", made.approximated},
                                      {"left_out", made.left_out}, {"kept_from_base", made.kept},
                                      {"notes", made.notes}};
    std::cout << j.dump(2) << '\n';
    return 0;
  }
  tell("Notes:", made.notes);
  tell("Came over, but not exactly:", made.approximated);
  tell("Not carried over, and of effect in PrusaSlicer:", made.left_out);
  tell(("Not said by the file; as in " + flags.base + " and our defaults:").c_str(), made.kept);
  std::fprintf(stderr, "%zu settings came over%s%s\n", made.values.size(),
               use.empty() ? "" : "; use it with --profile ", use.c_str());
  return 0;
}

}  // namespace

int profile_command(const std::vector<std::string>& args) {
  CLI::App app("Lists, shows and imports profiles", "profile");
  CommonFlags common;
  std::string name;
  app.require_subcommand(1);
  auto* list_app = app.add_subcommand("list", "every profile that can be named");
  auto* show_app = app.add_subcommand("show", "PRINTER[,MATERIAL[,QUALITY]] with everything resolved");
  show_app->add_option("name", name, "PRINTER[,MATERIAL[,QUALITY]]")->required();
  ImportFlags imported;
  auto* import_app =
      app.add_subcommand("import", "a PrusaSlicer configuration, bundle, or the end of its G-code");
  import_app->add_option("file", imported.file, "an .ini exported by PrusaSlicer, or its G-code")->required();
  auto* out =
      import_app->add_option("-o,--out", imported.out, "the complete profile to write; else it is printed");
  import_app
      ->add_option("--folder", imported.folder,
                   "writes printer, material and quality apart, below this folder")
      ->excludes(out);
  import_app->add_option("--name", imported.name, "of those three; else the file's");
  import_app->add_option("--base", imported.base, "the printer profile that says what the file does not");
  import_app->add_option("--printer", imported.presets.printer, "which printer preset of a bundle");
  import_app->add_option("--filament", imported.presets.filament, "which filament preset");
  import_app->add_option("--print", imported.presets.print, "which print preset");
  import_app->add_flag("--list", imported.list, "names the presets of a bundle");
  import_app->add_flag("--json", common.json, "print one JSON object on stdout and nothing else there");
  add_common(*list_app, common);
  add_common(*show_app, common);
  if (!parse(app, args)) return 0;
  if (import_app->parsed()) return import(common, imported);
  return list_app->parsed() ? list(common) : show(common, name);
}

}  // namespace voidpath::cli
