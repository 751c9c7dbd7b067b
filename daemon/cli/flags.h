#pragma once

#include <CLI/CLI.hpp>

#include "daemon/cli/offline.h"

/// Only for the commands' own .cpp files.
namespace voidpath::cli {

inline void add_common(CLI::App& app, CommonFlags& f) {
  app.add_flag("--json", f.json, "print one JSON object on stdout and nothing else there");
  app.add_option("--config", f.config, "configuration file");
  app.add_option("--profile", f.profile, "PRINTER[,MATERIAL[,QUALITY]], names or files");
  app.add_option("--scale", f.scale, "multiplies the model's lengths")->check(CLI::PositiveNumber);
  app.add_option("--threads", f.threads, "worker threads; the result does not depend on it");
  app.add_option("--set", f.set, "a profile value, such as slice.perimeters=3")->expected(1)->take_all();
}

inline void add_orient(CLI::App& app, OrientFlags& f) {
  app.add_option("--method", f.method, "toolpath, thesis, ahsan or as-delivered");
  app.add_option("--weights", f.weights, "h,v,d,c: weights of height, trapped volume, void distance, contours");
  app.add_option("--subdivisions", f.subdivisions, "samples 20*4^n directions and the six axes");
  app.add_option("--critical", f.critical, "normals or morse: which heights bound the slabs");
  app.add_option("--budget-s", f.budget_s, "seconds that timing candidates may take")->check(CLI::NonNegativeNumber);
}

/// Parses, mapping CLI11's errors to UsageError. Returns false when help was asked for and printed.
inline bool parse(CLI::App& app, const std::vector<std::string>& args) {
  try {
    app.parse(std::vector<std::string>(args.rbegin(), args.rend()));
    return true;
  } catch (const CLI::CallForHelp&) {
    std::fputs(app.help().c_str(), stdout);
    return false;
  } catch (const CLI::ParseError& e) {
    throw UsageError(app.get_name() + ": " + e.what());
  }
}

}  // namespace voidpath::cli
