#include "daemon/slicer/foreign.h"

#include "config/digest.h"
#include "config/fields.h"
#include "daemon/slicer/cura_settings.h"
#include "daemon/slicer/program.h"
#include "engine/mesh/write.h"
#include "engine/toolpath/emit/placeholders.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <deque>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include <stdlib.h>
#include <unistd.h>

namespace voidpath::daemon {

namespace fs = std::filesystem;

namespace {

/// Longer lines are cut: a slicer that dumps its settings need not fill the report.
constexpr std::size_t kLongestMessage = 400;
/// Of what a failed slicer said, so much is put into the job's reason.
constexpr std::size_t kReasonLines = 3;
/// What the slicer may take of the computer's memory; the daemon and its prints go on beside it.
constexpr double kMemoryShare = 0.75;

struct Slicer {
  std::string name;
  config::ProgramConfig given;
  fs::path program;
};

/// Readable by us alone, beside the file that is to come: on the same disk, and gone with the job's folder
/// should we not live to remove it.
class PrivateFolder {
 public:
  explicit PrivateFolder(const fs::path& beside) : path_(fs::absolute(beside).string() + ".slicing-XXXXXX") {
    if (::mkdtemp(path_.data()) == nullptr)
      throw std::runtime_error(path_ + ": cannot be made: " + std::generic_category().message(errno));
  }
  ~PrivateFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
  fs::path operator/(const char* name) const { return fs::path(path_) / name; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

std::uint64_t memory_limit(const config::ProgramConfig& given) {
  if (given.memory_limit_mb > 0) return static_cast<std::uint64_t>(given.memory_limit_mb * 1024 * 1024);
  const long pages = ::sysconf(_SC_PHYS_PAGES);
  const long size = ::sysconf(_SC_PAGESIZE);
  if (pages <= 0 || size <= 0) return 0;
  return static_cast<std::uint64_t>(kMemoryShare * static_cast<double>(pages) * static_cast<double>(size));
}

/// The profile as PrusaSlicer reads it, but for what would give us a file that is not text.
void copy_prusa_profile(const fs::path& from, const fs::path& to) {
  std::ifstream in(from, std::ios::binary);
  if (!in) throw std::runtime_error(from.string() + ": the slicer's profile cannot be read");
  std::ofstream out(to, std::ios::binary);
  std::string line;
  while (std::getline(in, line))
    if (!line.starts_with("binary_gcode")) out << line << '\n';
  out.close();
  if (in.bad() || !out) throw std::runtime_error(to.string() + ": cannot be written");
}

std::vector<std::string> prusa_args(const Slicer& slicer, const PrivateFolder& folder,
                                    const pipeline::PlacedPart& part, const fs::path& model,
                                    const fs::path& gcode) {
  copy_prusa_profile(slicer.given.profile, folder / "profile.ini");
  std::vector<std::string> args = {
      slicer.program.string(),
      "--export-gcode",
      "--load",
      (folder / "profile.ini").string(),
      "--datadir",
      (folder / "settings").string(),
      "--dont-arrange",
      "--center",
      config::number_text(part.centre_mm[0]) + "," + config::number_text(part.centre_mm[1]),
      "--output",
      gcode.string()};
  if (part.holding_brim_mm > 0)
    for (const std::string& word : {std::string("--brim-type"), std::string("outer_only"),
                                    std::string("--brim-width"), config::number_text(part.holding_brim_mm)})
      args.push_back(word);
  args.push_back(model.string());
  return args;
}

/// Placeholders in what the user's settings bring along, by the settings' own names.
void expand_own_gcode(CuraSettings& settings, const CuraSettings& user) {
  const toolpath::Placeholders values(settings.begin(), settings.end());
  for (const std::string key : {"machine_start_gcode", "machine_end_gcode"})
    if (user.contains(key))
      settings[key] = toolpath::expand(user.at(key), values, key + " of the Cura settings");
}

std::vector<std::string> cura_args(const Slicer& slicer, const pipeline::PlacedPart& part,
                                   const fs::path& model, const fs::path& gcode) {
  const CuraSettings user =
      slicer.given.profile.empty() ? CuraSettings{} : read_cura_settings(slicer.given.profile);
  CuraSettings settings = cura_settings(part.print);
  for (const auto& [key, value] : user) settings[key] = value;
  mesh::Bounds bounds = mesh::bounds(part.mesh);
  for (geom::Vec3* corner : {&bounds.min, &bounds.max})
    *corner += geom::Vec3(part.centre_mm[0], part.centre_mm[1], 0);
  CuraSettings frame = cura_start_and_end(part.print, settings, bounds);
  frame.insert({{"mesh_position_x", "0"},
                {"mesh_position_y", "0"},
                {"mesh_position_z", "0"},
                {"center_object", "false"}});
  for (const auto& [key, value] : frame)
    if (!user.contains(key) || key.starts_with("mesh_") || key == "center_object") settings[key] = value;
  expand_own_gcode(settings, user);
  // Where the part stands is ours to say: the machine as our profile knows it.
  const CuraSettings ours = cura_settings(part.print);
  for (const char* key : {"machine_width", "machine_depth", "machine_center_is_zero"})
    settings[key] = ours.at(key);
  if (part.holding_brim_mm > 0) {
    settings["adhesion_type"] = "brim";
    for (const char* key : {"brim_width", "brim_line_count"}) settings[key] = ours.at(key);
  }
  std::vector<std::string> args = {slicer.program.string(),          "slice", "-j",
                                   slicer.given.definition.string(), "-o",    gcode.string()};
  for (std::string& word : cura_arguments(settings)) args.push_back(std::move(word));
  args.emplace_back("-l");
  args.push_back(model.string());
  return args;
}

/// Definitions say what they inherit by name: looked up beside them, and where Cura keeps the extruders'.
std::string cura_search_path(const fs::path& definition) {
  const fs::path folder = fs::absolute(definition).parent_path();
  std::string path = folder.string() + ":" + (folder.parent_path() / "extruders").string() + ":" +
                     (folder.parent_path() / "definitions").string();
  if (const char* given = std::getenv("CURA_ENGINE_SEARCH_PATH"); given != nullptr && *given != '\0')
    path += std::string(":") + given;
  return path;
}

std::string last_of(const std::vector<std::string>& messages) {
  std::string out;
  const std::size_t first = messages.size() - std::min(messages.size(), kReasonLines);
  for (std::size_t i = first; i < messages.size(); ++i) out += (out.empty() ? "" : " | ") + messages[i];
  return out;
}

std::string why_it_failed(const Slicer& slicer, const ProgramEnd& end,
                          const std::vector<std::string>& messages) {
  std::string why = slicer.name;
  switch (end.kind) {
    case ProgramEnd::Kind::timed_out:
      why += " took longer than " + config::number_text(slicer.given.time_limit_s) +
             " s and was ended (time_limit_s)";
      break;
    case ProgramEnd::Kind::killed:
      why += std::string(" was ended by a signal: ") + ::strsignal(end.code) +
             (end.code == SIGKILL || end.code == SIGABRT || end.code == SIGSEGV
                  ? "; it may want more memory (memory_limit_mb)"
                  : "");
      break;
    case ProgramEnd::Kind::exited:
      why += end.code != 0 ? " failed with code " + std::to_string(end.code) : " wrote no G-code";
      break;
    case ProgramEnd::Kind::stopped:
      break;
  }
  const std::string said = last_of(messages);
  return why + (said.empty() ? "; it said nothing" : "; it said: " + said);
}

std::vector<std::string> slice(const Slicer& slicer, const pipeline::PlacedPart& part, const fs::path& gcode,
                               const run::Context& ctx) {
  ctx.check();
  const PrivateFolder folder(gcode);
  const fs::path model = folder / "part.stl";
  const fs::path made = folder / "part.gcode";
  mesh::write_model(part.mesh, model);
  ProgramCall call;
  const bool prusa = slicer.name == config::kPrusaSlicer;
  call.args = prusa ? prusa_args(slicer, folder, part, model, made) : cura_args(slicer, part, model, made);
  // Numbers in arguments and files have points, whatever language the user's console speaks.
  call.environment = {{"LC_ALL", "C.UTF-8"}, {"TMPDIR", folder.path()}};
  if (!prusa)
    call.environment.emplace_back("CURA_ENGINE_SEARCH_PATH", cura_search_path(slicer.given.definition));
  call.folder = folder.path();
  call.log = folder / "log";
  call.time_limit_s = slicer.given.time_limit_s;
  call.memory_limit_bytes = memory_limit(slicer.given);
  const ProgramEnd end = run_program(call, ctx.stop);
  if (end.kind == ProgramEnd::Kind::stopped) throw run::Stopped();
  std::vector<std::string> messages = messages_in(call.log);
  std::error_code ec;
  const bool wrote = fs::file_size(made, ec) > 0 && !ec;
  if (end.kind != ProgramEnd::Kind::exited || end.code != 0 || !wrote)
    throw std::runtime_error(why_it_failed(slicer, end, messages));
  fs::rename(made, gcode);
  for (std::string& message : messages) message.insert(0, slicer.name + ": ");
  return messages;
}

/// The slicer asked for and what it is given; the program is not looked up yet.
std::optional<Slicer> chosen(const config::SlicerConfig& configured, const std::string& named,
                             const fs::path& profile) {
  config::SlicerConfig slicer = configured;
  if (!named.empty()) slicer.name = named;
  const config::ProgramConfig* given = slicer.program();
  if (given == nullptr) return std::nullopt;
  Slicer out{slicer.name, *given, {}};
  if (!profile.empty()) out.given.profile = profile;
  return out;
}

}  // namespace

std::vector<std::string> messages_in(const fs::path& log) {
  std::ifstream in(log, std::ios::binary);
  std::deque<std::string> kept;
  std::string line;
  while (std::getline(in, line)) {
    // Progress: PrusaSlicer's "20 => Generating perimeters", CuraEngine's "Progress:inset+skin:5:11".
    const std::size_t arrow = line.find(" => ");
    const bool percent =
        arrow != std::string::npos && arrow <= 3 && line.find_first_not_of("0123456789") == arrow;
    if (percent || line.starts_with("Progress:")) continue;
    std::erase_if(line, [](char c) { return static_cast<unsigned char>(c) < ' '; });
    if (line.find_first_not_of(' ') == std::string::npos) continue;
    if (line.size() > kLongestMessage) line = line.substr(0, kLongestMessage) + "...";
    kept.push_back(line);
    if (kept.size() > kMostMessages) kept.pop_front();
  }
  return {kept.begin(), kept.end()};
}

pipeline::ForeignSlicer foreign_slicer(const config::SlicerConfig& configured, const std::string& named,
                                       const fs::path& profile) {
  std::optional<Slicer> slicer = chosen(configured, named, profile);
  if (!slicer) return {};
  const bool prusa = slicer->name == config::kPrusaSlicer;
  const config::ProgramConfig given = slicer->given;
  const std::string section = prusa ? "prusa_slicer" : "cura_engine";
  slicer->program = find_program(given.program);
  if (slicer->program.empty())
    throw std::runtime_error(slicer->name + ": there is no program " + given.program +
                             "; install it (apt install " + (prusa ? "prusa-slicer" : "cura-engine") +
                             ") or set " + section + ".program");
  std::error_code ec;
  const auto wanted = [&](const fs::path& file, const std::string& key, const std::string& what) {
    if (file.empty()) throw std::runtime_error(slicer->name + ": " + what + " (" + section + "." + key + ")");
    if (!fs::is_regular_file(file, ec))
      throw std::runtime_error(slicer->name + ": there is no file " + file.string());
  };
  if (prusa)
    wanted(given.profile, "profile", "it wants your profile, as PrusaSlicer exports it");
  else
    wanted(given.definition, "definition",
           "it wants the machine's definition, such as Cura's fdmprinter.def.json");
  if (!prusa && !given.profile.empty()) {
    wanted(given.profile, "settings", "");
    read_cura_settings(given.profile);  // tells what is wrong with it before the search for an orientation
  }
  // It runs in a folder of its own.
  for (fs::path* file : {&slicer->given.profile, &slicer->given.definition})
    if (!file->empty()) *file = fs::absolute(*file);
  return [slicer = *slicer](const pipeline::PlacedPart& part, const fs::path& gcode,
                            const run::Context& ctx) { return slice(slicer, part, gcode, ctx); };
}

std::string slicing_sha256(const config::SlicerConfig& configured, const std::string& named,
                           const fs::path& profile, const std::string& ours) {
  const std::optional<Slicer> slicer = chosen(configured, named, profile);
  if (!slicer) return ours;
  std::string all = ours + "\n" + slicer->name + "\n";
  for (const fs::path& file : {slicer->given.profile, slicer->given.definition})
    if (!file.empty()) all += config::sha256_of_file(file) + "\n";
  return config::sha256_of(all);
}

}  // namespace voidpath::daemon
