#include "config/config.h"
#include "config/fields.h"
#include "config/pins.h"

#include <cstdlib>
#include <set>

namespace voidpath::config {

namespace fs = std::filesystem;

namespace {

const Names<orient::Method> kMethods = {{"toolpath", orient::Method::toolpath},
                                        {"thesis", orient::Method::thesis},
                                        {"ahsan", orient::Method::ahsan},
                                        {"as-delivered", orient::Method::as_delivered}};

void read_orient(Reader& r, OrientConfig& o) {
  auto& s = o.search;
  r.choice("method", s.method, kMethods);
  r.number("budget_s", o.budget_s, {0, 86400});
  r.integer("subdivisions", s.subdivisions, {0, 6});
  r.choice("critical", s.critical,
           {{"normals", orient::CriticalRule::normals}, {"morse", orient::CriticalRule::morse}});
  r.number("normal_tolerance_deg", s.normal_tolerance_deg, {0, 90});
  r.number("min_slab_mm", s.min_slab_mm, {0, 100});
  r.section("weights", [&](Reader& w) {
    w.number("h", s.weights.h, {0, 1000});
    w.number("v", s.weights.v, {0, 1000});
    w.number("d", s.weights.d, {0, 1000});
    w.number("c", s.weights.c, {0, 1000});
  });
  r.number("min_contact_mm2", s.limits.min_contact_mm2, {0, 1e6});
  r.number("min_contact_share", s.limits.min_contact_share, {0, 1});
  r.number("contact_depth_mm", s.limits.contact_depth_mm, {0, 10});
  r.number("stability_margin_mm", s.limits.stability_margin_mm, {0, 100});
  r.number("bed_margin_mm", s.limits.bed_margin_mm, {0, 100});
}

const Names<std::string> kSlicers = {
    {kBuiltinSlicer, kBuiltinSlicer}, {kPrusaSlicer, kPrusaSlicer}, {kCuraEngine, kCuraEngine}};

/// A relative path in a configuration file is meant from that file's folder.
fs::path anchored(const fs::path& path, const fs::path& base) {
  return path.empty() || path.is_absolute() || base.empty() ? path : base / path;
}

void read_program(Reader& r, ProgramConfig& p, const fs::path& base, const char* profile_key) {
  r.text("program", p.program);
  if (p.program.empty()) r.fail("program", "a program's name or path is wanted");
  r.path(profile_key, p.profile);
  p.profile = anchored(p.profile, base);
  r.number("time_limit_s", p.time_limit_s, {1, 86400});
  r.number("memory_limit_mb", p.memory_limit_mb, {0, 1e6});
}

void read_slicer(Reader& r, SlicerConfig& s, const fs::path& base) {
  r.choice("slicer", s.name, kSlicers);
  r.section("prusa_slicer", [&](Reader& p) { read_program(p, s.prusa_slicer, base, "profile"); });
  r.section("cura_engine", [&](Reader& p) {
    read_program(p, s.cura_engine, base, "settings");
    p.path("definition", s.cura_engine.definition);
    s.cura_engine.definition = anchored(s.cura_engine.definition, base);
  });
}

void read_printer(Reader& r, PrinterConfig& p, const fs::path& base) {
  r.text("name", p.name);
  r.text("profile", p.profile);
  r.text("material", p.material);
  r.text("quality", p.quality);
  r.text("port", p.port);
  r.integer("baud", p.baud, {2400, 4000000});  // 1200 puts a 32U4 or a SAMD in its bootloader
  r.choice("meatpack", p.meatpack, {{"auto", true}, {"off", false}});
  r.integer("keepalive_s", p.keepalive_s, {0, 60});  // 60: Marlin takes no more
  r.flag("reset_on_connect", p.reset_on_connect);
  r.paths("watch", p.watch);
  r.flag("auto_clear", p.auto_clear);
  r.path("clock", p.clock);
  r.section("pins", [&](Reader& pins) { read_pins(pins, p.pins); });
  r.path("slicer_profile", p.slicer_profile);
  if (p.name.empty()) r.fail("name", "every printer needs a name");
  if (p.profile.empty()) r.fail("profile", "which printer is it? Name a profile, such as generic-marlin");
  if (p.port.empty()) r.fail("port", "a serial port is wanted, such as /dev/serial/by-id/usb-...");
  for (fs::path& w : p.watch) w = anchored(w, base);
  p.clock = anchored(p.clock, base);
  p.slicer_profile = anchored(p.slicer_profile, base);
  if (p.profile.find('/') != std::string::npos) p.profile = anchored(p.profile, base).string();
}

/// What the slicer is to be given must be there, for every printer.
void check_slicer(const DaemonConfig& c) {
  const ProgramConfig* program = c.slicer.program();
  if (program == nullptr) return;
  const bool prusa = c.slicer.name == kPrusaSlicer;
  const auto wanted = [&](const fs::path& file, const std::string& key, const std::string& what) {
    std::error_code ec;
    if (file.empty()) throw ConfigError(c.file.string() + ": " + key + ": " + what);
    if (!fs::is_regular_file(file, ec))
      throw ConfigError(c.file.string() + ": " + key + ": there is no file " + file.string());
  };
  if (!prusa)
    wanted(program->definition, "cura_engine.definition",
           "name the machine's definition, such as fdmprinter.def.json");
  for (const PrinterConfig& p : c.printers) {
    const fs::path& profile = p.slicer_profile.empty() ? program->profile : p.slicer_profile;
    if (prusa)
      wanted(profile, "prusa_slicer.profile", "name a configuration exported by PrusaSlicer, for " + p.name);
    else if (!profile.empty())
      wanted(profile, "cura_engine.settings", "");
  }
}

void check_printers(const DaemonConfig& c) {
  std::set<std::string> names, ports;
  for (const PrinterConfig& p : c.printers) {
    const std::string place = c.file.string() + ": printers: ";
    if (!names.insert(p.name).second) throw ConfigError(place + "two printers are called '" + p.name + "'");
    if (!ports.insert(p.port).second) throw ConfigError(place + "two printers use " + p.port);
    load_profile(p.profile, p.material, p.quality);
  }
  check_folders(c);
  check_pins(c);
  check_slicer(c);
}

/// The folder itself, whatever links lead to it; it need not exist yet.
fs::path real_folder(const fs::path& folder) {
  std::error_code error;
  fs::path out = fs::absolute(folder, error);
  if (error) out = folder;
  const fs::path real = fs::weakly_canonical(out, error);
  out = error ? out.lexically_normal() : real;
  return out.has_filename() || !out.has_relative_path() ? out : out.parent_path();
}

struct WatchedFolder {
  std::string printer;
  fs::path as_given;
  fs::path real;
};

}  // namespace

fs::path default_config_file() {
  if (const char* file = std::getenv("VOIDPATH_CONFIG"); file != nullptr && *file != '\0') return file;
  std::error_code ec;
  for (const fs::path& dir : search_path()) {
    if (fs::exists(dir / "voidpath.yaml", ec)) return dir / "voidpath.yaml";
    if (dir == "/etc/voidpath") break;  // behind it come the examples we ship, which are nobody's choice
  }
  return {};
}

void check_folders(const DaemonConfig& config) {
  const std::string place = config.file.empty() ? "" : config.file.string() + ": printers: ";
  std::vector<WatchedFolder> folders;
  for (const PrinterConfig& p : config.printers)
    for (const fs::path& w : p.watch) {
      const fs::path real = real_folder(w);
      for (const WatchedFolder& other : folders)
        if (other.real == real)
          throw ConfigError(place + "the folder " + w.string() + " of " + p.name +
                            " is watched twice: it is the same as " + other.as_given.string() + " of " +
                            other.printer);
      folders.push_back({p.name, w, real});
    }
  for (const WatchedFolder& from : folders)
    for (const char* name : {"done", "failed"})
      for (const WatchedFolder& to : folders)
        if (to.real == real_folder(from.as_given / name))
          throw ConfigError(place + "the folder " + to.as_given.string() + " of " + to.printer +
                            " is where files from " + from.as_given.string() + " of " + from.printer +
                            " are put when they are " + name + ": they would be printed again");
}

DaemonConfig load_daemon(const fs::path& file) {
  DaemonConfig c;
  c.file = file;
  const Tree tree = read_yaml_file(file);
  const fs::path base = fs::absolute(file).parent_path();
  Reader r(tree, file.string(), "");
  r.path("state_dir", c.state_dir);
  c.state_dir = anchored(c.state_dir, base);
  r.section("web", [&](Reader& w) { w.text("listen", c.listen); });
  r.section("orient", [&](Reader& o) { read_orient(o, c.orient); });
  read_slicer(r, c.slicer, base);
  r.number("settle_s", c.settle_s, {0, 3600});
  r.each("printers", [&](Reader& p) {
    PrinterConfig printer;
    read_printer(p, printer, base);
    c.printers.push_back(std::move(printer));
  });
  r.finish();
  check_printers(c);
  return c;
}

JobOverrides load_overrides(const fs::path& file) {
  JobOverrides o;
  const Tree tree = read_yaml_file(file);
  Reader r(tree, file.string(), "");
  r.choice("method", o.method,
           {{"toolpath", std::string("toolpath")},
            {"thesis", std::string("thesis")},
            {"ahsan", std::string("ahsan")},
            {"as-delivered", std::string("as-delivered")}});
  bool as_delivered = false;
  r.flag("as_delivered", as_delivered);
  if (as_delivered) o.method = "as-delivered";
  r.choice("slicer", o.slicer, kSlicers);
  r.text("material", o.material);
  r.text("quality", o.quality);
  if (r.has("scale")) r.number("scale", o.scale.emplace(), {1e-6, 1e6});
  if (r.has("copies")) r.integer("copies", o.copies.emplace(), {1, 1000});
  if (r.has("set"))
    for (const Tree::Entry& e : tree.map) {
      if (e.key != "set") continue;
      if (e.value.kind != Tree::Kind::map) r.fail("set", "'section.key: value' lines are wanted below it");
      for (const Tree::Entry& s : e.value.map) {
        if (s.value.kind != Tree::Kind::scalar) r.fail("set", "'" + s.key + "' wants a single value");
        o.set.emplace_back(s.key, s.value.scalar);
      }
    }
  r.finish();
  return o;
}

}  // namespace voidpath::config
