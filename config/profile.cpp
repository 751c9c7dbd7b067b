#include "config/config.h"
#include "config/digest.h"
#include "config/fields.h"
#include "config/profile_fields.h"
#include "engine/render/thumbnail.h"

#include <algorithm>
#include <cstdlib>

#include <algorithm>
#include <cstdlib>

namespace voidpath::config {

namespace fs = std::filesystem;

namespace {

/// A profile that names itself as its base, directly or not, is caught by this depth.
constexpr int kMaxBases = 8;

/// Laid over a printer's profile that is not complete by itself, when none is named.
constexpr const char* kDefaultMaterial = "pla";
constexpr const char* kDefaultQuality = "0.20mm";

const char* const kFolders[] = {"printers", "materials", "qualities"};

fs::path find_profile(const std::string& kind, const std::string& name) {
  std::error_code ec;
  if (name.ends_with(".yaml") || name.ends_with(".yml") || name.find('/') != std::string::npos) {
    if (!fs::exists(name, ec)) throw ConfigError(name + ": no such profile file");
    return name;
  }
  for (const fs::path& dir : search_path()) {
    const fs::path file = dir / kind / (name + ".yaml");
    if (fs::exists(file, ec)) return file;
  }
  std::vector<std::string> known;
  for (const ProfileEntry& e : list_profiles())
    if (e.kind + "s" == kind || (kind == "qualities" && e.kind == "quality")) known.push_back(e.name);
  const std::string near = nearest(name, known);
  std::string all;
  for (const std::string& k : known) all += (all.empty() ? "" : ", ") + k;
  const std::string what = kind == "qualities" ? "quality" : kind.substr(0, kind.size() - 1);
  throw ConfigError("no " + what + " profile is called '" + name + "'" +
                    (near.empty() ? "" : "; did you mean '" + near + "'?") +
                    (all.empty() ? "" : " Known: " + all + "."));
}

void lay_over(Profile& profile, const std::string& kind, const fs::path& file, int depth) {
  if (depth > kMaxBases) throw ConfigError(file.string() + ": its 'base' leads back to itself");
  const Tree tree = read_yaml_file(file);
  Reader reader(tree, file.string(), "");
  std::string base;
  std::string description;
  reader.text("base", base);
  reader.text("description", description);
  bool complete = false;
  reader.flag("complete", complete);
  if (!base.empty()) lay_over(profile, kind, find_profile(kind, base), depth + 1);
  visit_profile(reader, profile);
  reader.finish();
}

/// Whether the printer's profile names material and quality settings of its own, so that none is laid over it
/// unasked.
bool is_complete(const fs::path& file) {
  const Tree tree = read_yaml_file(file);
  for (const Tree::Entry& e : tree.map)
    if (e.key == "complete")
      return e.value.scalar == "true" || e.value.scalar == "yes" || e.value.scalar == "on";
  return false;
}

void apply_set(Profile& profile, const std::string& key, const std::string& value) {
  const std::string name = "--set " + key;
  const std::size_t dot = key.find('.');
  if (dot == std::string::npos || dot == 0 || dot + 1 == key.size())
    throw ConfigError(name + ": write it as section.key=value, such as slice.perimeters=3");
  // Dots nest: machine.serial.rx_bytes=1024.
  Tree tree = read_yaml_text(value, name);
  std::string rest = key;
  while (!rest.empty()) {
    const std::size_t last = rest.rfind('.');
    const std::string word = last == std::string::npos ? rest : rest.substr(last + 1);
    rest = last == std::string::npos ? "" : rest.substr(0, last);
    Tree outer;
    outer.kind = Tree::Kind::map;
    outer.map.push_back({word, 0, std::move(tree)});
    tree = std::move(outer);
  }
  Reader reader(tree, name, "");
  visit_profile(reader, profile);
  reader.finish();
}

/// What follows from several keys at once.
void check(const Profile& p) {
  const auto& s = p.print.slice;
  const double nozzle = p.print.machine.nozzle_mm;
  const auto fail = [&](const std::string& what) {
    throw ConfigError("profile " + p.printer + "," + p.material + "," + p.quality + ": " + what);
  };
  for (const std::string& size : p.print.machine.thumbnails) {
    try {
      render::picture_size(size);
    } catch (const std::invalid_argument& e) {
      fail(std::string("machine.thumbnails: ") + e.what());
    }
  }
  if (s.layer_height_mm > nozzle) fail("slice.layer_height_mm is larger than machine.nozzle_mm");
  if (s.adaptive_layers) {
    if (s.min_layer_height_mm > s.max_layer_height_mm)
      fail("slice.min_layer_height_mm is larger than slice.max_layer_height_mm");
    if (s.max_layer_height_mm > nozzle) fail("slice.max_layer_height_mm is larger than machine.nozzle_mm");
    if (s.line_width_mm < s.max_layer_height_mm)
      fail("slice.line_width_mm is smaller than slice.max_layer_height_mm");
  }
  if (s.first_layer_height_mm > nozzle) fail("slice.first_layer_height_mm is larger than machine.nozzle_mm");
  if (s.line_width_mm < s.layer_height_mm) fail("slice.line_width_mm is smaller than slice.layer_height_mm");
  if (s.first_layer_line_width_mm < s.first_layer_height_mm)
    fail("slice.first_layer_line_width_mm is smaller than slice.first_layer_height_mm");
}

/// Limits that are the same fact under another name.
void derive(Profile& p) {
  p.limits.travel_mm = {p.print.machine.bed_mm[0], p.print.machine.bed_mm[1], p.print.machine.height_mm};
}

}  // namespace

std::vector<fs::path> search_path() {
  std::vector<fs::path> path;
  if (const char* dir = std::getenv("VOIDPATH_PROFILES"); dir != nullptr && *dir != '\0')
    path.emplace_back(dir);
  if (const char* xdg = std::getenv("XDG_CONFIG_HOME"); xdg != nullptr && *xdg != '\0')
    path.emplace_back(fs::path(xdg) / "voidpath");
  else if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0')
    path.emplace_back(fs::path(home) / ".config/voidpath");
  path.emplace_back("/etc/voidpath");
  std::error_code ec;
  const fs::path program = fs::read_symlink("/proc/self/exe", ec);
  if (!ec) {
    const fs::path bin = program.parent_path();
    path.push_back(bin.parent_path() / "share/voidpath");  // installed, wherever to
    path.push_back(bin / "../../../config");               // build/<preset>/bin in a source tree
  }
  path.emplace_back(VOIDPATH_DATA_DIR);
  return path;
}

std::vector<ProfileEntry> list_profiles() {
  std::vector<ProfileEntry> found;
  for (const fs::path& dir : search_path())
    for (const std::string folder : kFolders) {
      std::error_code ec;
      for (fs::directory_iterator it(dir / folder, ec), end; !ec && it != end; it.increment(ec)) {
        if (it->path().extension() != ".yaml") continue;
        const std::string kind = folder == "qualities" ? "quality" : folder.substr(0, folder.size() - 1);
        const std::string name = it->path().stem().string();
        const bool hidden = std::any_of(found.begin(), found.end(), [&](const ProfileEntry& e) {
          return e.kind == kind && e.name == name;
        });
        if (!hidden) found.push_back({kind, name, it->path()});
      }
    }
  std::sort(found.begin(), found.end(), [](const ProfileEntry& a, const ProfileEntry& b) {
    return std::tie(a.kind, a.name) < std::tie(b.kind, b.name);
  });
  return found;
}

Profile load_profile(const std::string& printer, const std::string& material, const std::string& quality,
                     const std::vector<std::pair<std::string, std::string>>& set) {
  Profile p;
  const fs::path machine = find_profile("printers", printer);
  const bool complete = is_complete(machine);
  p.printer = printer;
  p.material = material.empty() && !complete ? kDefaultMaterial : material;
  p.quality = quality.empty() && !complete ? kDefaultQuality : quality;
  lay_over(p, "printers", machine, 0);
  if (!p.material.empty()) lay_over(p, "materials", find_profile("materials", p.material), 0);
  if (!p.quality.empty()) lay_over(p, "qualities", find_profile("qualities", p.quality), 0);
  for (const auto& [key, value] : set) apply_set(p, key, value);
  derive(p);
  check(p);
  p.sha256 = sha256_of(profile_text(p));
  return p;
}

Profile load_profile(const std::string& spec, const std::vector<std::pair<std::string, std::string>>& set) {
  std::vector<std::string> part(3);
  std::size_t begin = 0;
  for (std::size_t i = 0; begin <= spec.size(); ++i) {
    const std::size_t comma = std::min(spec.find(',', begin), spec.size());
    if (i >= part.size()) throw ConfigError("profile '" + spec + "': write PRINTER[,MATERIAL[,QUALITY]]");
    if (comma > begin) part[i] = spec.substr(begin, comma - begin);
    begin = comma + 1;
  }
  if (part[0].empty()) throw ConfigError("profile '" + spec + "': a printer is wanted first");
  return load_profile(part[0], part[1], part[2], set);
}

std::string profile_text(const Profile& profile) {
  Profile copy = profile;
  Writer writer;
  visit_profile(writer, copy);
  return writer.text();
}

orient::SearchOptions search_options(const OrientConfig& config, const Profile& profile) {
  orient::SearchOptions options = config.search;
  options.limits.volume_mm = {profile.print.machine.bed_mm[0], profile.print.machine.bed_mm[1],
                              profile.print.machine.height_mm};
  return options;
}

}  // namespace voidpath::config
