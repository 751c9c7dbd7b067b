#include "daemon/cli/offline.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <mutex>

#include <unistd.h>

#include "config/fields.h"

namespace voidpath::cli {

std::vector<double> numbers_from(const std::string& flag, const std::string& text, std::size_t count) {
  std::vector<double> out;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    try {
      out.push_back(config::parse_number(text.substr(begin, comma - begin)));
    } catch (const std::invalid_argument& e) {
      throw UsageError(flag + " " + text + ": " + e.what());
    }
    begin = comma + 1;
  }
  if (out.size() != count)
    throw UsageError(flag + " " + text + ": " + std::to_string(count) + " numbers with commas between are wanted");
  return out;
}

std::vector<std::pair<std::string, std::string>> pairs_from(const std::vector<std::string>& set) {
  std::vector<std::pair<std::string, std::string>> out;
  for (const std::string& s : set) {
    const std::size_t eq = s.find('=');
    if (eq == std::string::npos || eq == 0) throw UsageError("--set " + s + ": write it as key=value");
    out.emplace_back(s.substr(0, eq), s.substr(eq + 1));
  }
  return out;
}

Settings settings_from(const CommonFlags& common, const OrientFlags& orient) {
  Settings s;
  const std::filesystem::path file(common.config.empty() ? config::default_config_file().string() : common.config);
  if (!file.empty()) s.daemon = config::load_daemon(file);
  const auto set = pairs_from(common.set);
  if (!common.profile.empty()) {
    s.profile = config::load_profile(common.profile, set);
  } else if (!s.daemon.printers.empty()) {
    const auto& p = s.daemon.printers.front();
    s.profile = config::load_profile(p.profile, p.material, p.quality, set);
    s.profile.limits.baud = p.baud;
  } else {
    s.profile = config::load_profile("generic-marlin", set);
  }
  auto& o = s.options;
  o.import.scale = common.scale;
  o.orient = config::search_options(s.daemon.orient, s.profile);
  if (!orient.method.empty()) {
    const auto method = orient::method_from(orient.method);
    if (!method)
      throw UsageError("--method " + orient.method + ": one of toolpath, thesis, ahsan, as-delivered is wanted");
    o.orient.method = *method;
  }
  if (o.orient.method == orient::Method::ahsan) o.orient.weights = orient::kAhsanWeights;
  if (!orient.weights.empty()) {
    const auto w = numbers_from("--weights", orient.weights, 4);
    for (const double x : w)
      if (x < 0) throw UsageError("--weights " + orient.weights + ": weights are not negative");
    o.orient.weights = {w[0], w[1], w[2], w[3]};
  }
  if (orient.subdivisions != -1) {
    if (orient.subdivisions < 0 || orient.subdivisions > 6)
      throw UsageError("--subdivisions " + std::to_string(orient.subdivisions) + ": 0 to 6 is wanted");
    o.orient.subdivisions = orient.subdivisions;
  }
  if (orient.critical == "morse")
    o.orient.critical = orient::CriticalRule::morse;
  else if (orient.critical == "normals")
    o.orient.critical = orient::CriticalRule::normals;
  else if (!orient.critical.empty())
    throw UsageError("--critical " + orient.critical + ": normals or morse is wanted");
  o.budget_s = orient.budget_s >= 0 ? orient.budget_s : s.daemon.orient.budget_s;
  o.now_s = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  };
  o.print = s.profile.print;
  o.limits = s.profile.limits;
  return s;
}

namespace {

bool is_terminal() {
  static const bool terminal = ::isatty(STDERR_FILENO) == 1;
  return terminal;
}

}  // namespace

run::Context console_context(unsigned threads) {
  run::Context ctx;
  ctx.threads = threads;
  if (!is_terminal()) return ctx;
  auto mutex = std::make_shared<std::mutex>();
  auto last = std::make_shared<std::string>();
  ctx.on_progress = [mutex, last](std::string_view phase, double fraction) {
    const int percent = static_cast<int>(std::lround(100 * fraction));
    std::string line = std::string(phase) + " " + std::to_string(percent) + " %";
    const std::lock_guard lock(*mutex);
    if (line == *last) return;
    std::fprintf(stderr, "\r\033[K%s", line.c_str());
    std::fflush(stderr);
    *last = std::move(line);
  };
  return ctx;
}

void end_progress() {
  if (is_terminal()) std::fputs("\r\033[K", stderr);
}

std::string fixed(double value, int decimals) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, "%.*f", decimals, value);
  return buffer;
}

std::string duration_text(double seconds) {
  if (seconds < 60) return fixed(seconds, 1) + " s";
  const long total = std::lround(seconds);
  const long h = total / 3600;
  const long m = total / 60 % 60;
  if (h == 0) return std::to_string(m) + " min " + std::to_string(total % 60) + " s";
  return std::to_string(h) + " h " + (m < 10 ? "0" : "") + std::to_string(m) + " min";
}

}  // namespace voidpath::cli
