#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "engine/motion/limits.h"
#include "engine/orient/search.h"
#include "engine/toolpath/settings.h"

/// The only room that reads YAML. Everyone else sees these structs.
namespace voidpath::config {

/// what(): file, line, what is wrong, and the nearest valid key where a key is unknown.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A printer, a material and a quality, laid over one another.
struct Profile {
  std::string printer;   ///< names, as given
  std::string material;
  std::string quality;
  toolpath::PrintSettings print;
  motion::MachineLimits limits;
  std::vector<std::string> cancel_gcode;
  int extruders = 1;        ///< s3g only
  bool heated_bed = true;   ///< s3g only
  std::string sha256;  ///< of the resolved values: the same settings give the same hash
};

struct OrientConfig {
  orient::SearchOptions search;  ///< limits are filled from the profile's machine by search_options()
  double budget_s = 20;
};

enum class PinBias { as_is, disabled, pull_up, pull_down };

struct PinConfig {
  std::string chip;  ///< device name, path or label; empty: whichever chip has the line
  std::string line;  ///< name or offset
  bool active_low = false;
  PinBias bias = PinBias::as_is;
  double debounce_ms = 0;  ///< inputs: a change counts once it has lasted for this long
};

/// What is wired to the computer's pins; what is not named is not there. Inputs with a normally closed contact
/// to ground are active when the contact opens, so that a cut wire counts as well.
struct PinsConfig {
  std::optional<PinConfig> emergency_stop;  ///< active: pulled
  std::optional<PinConfig> bed_button;      ///< active: pressed
  std::optional<PinConfig> door;            ///< active: open
  std::optional<PinConfig> filament;        ///< active: none left
  std::optional<PinConfig> relay;           ///< active: the heaters' supply is on
  std::optional<PinConfig> led;
  std::optional<PinConfig> light;
  double power_up_s = 3;        ///< from the relay's click until the printer may be spoken to
  double idle_off_s = 0;        ///< the relay goes off after so long without work; 0: it stays on
  bool light_printing = true;   ///< the light goes on with a print, and off after it
};

inline constexpr const char* kBuiltinSlicer = "builtin";
inline constexpr const char* kPrusaSlicer = "prusa-slicer";
inline constexpr const char* kCuraEngine = "cura-engine";

/// A slicer that is installed beside voidpath, and what it is given.
struct ProgramConfig {
  std::string program;             ///< a name to look up in PATH, or a path
  std::filesystem::path profile;   ///< PrusaSlicer: its exported configuration; Cura: settings, key = value
  std::filesystem::path definition;  ///< Cura only: the machine's .def.json
  double time_limit_s = 900;
  double memory_limit_mb = 0;  ///< 0: three quarters of the computer's
};

struct SlicerConfig {
  std::string name = kBuiltinSlicer;
  ProgramConfig prusa_slicer{.program = "prusa-slicer", .profile = {}, .definition = {}};
  ProgramConfig cura_engine{.program = "CuraEngine", .profile = {}, .definition = {}};

  /// The one that is named; of the built-in one, nothing.
  const ProgramConfig* program() const {
    return name == kPrusaSlicer ? &prusa_slicer : name == kCuraEngine ? &cura_engine : nullptr;
  }
  ProgramConfig* program() { return const_cast<ProgramConfig*>(std::as_const(*this).program()); }
};

struct PrinterConfig {
  std::string name;
  std::string profile;
  std::string material;  ///< empty: pla, or the printer profile's own if that is complete
  std::string quality;   ///< empty: 0.20mm, likewise
  std::string port;
  int baud = 115200;
  bool meatpack = true;  ///< lines go packed where the firmware offers it
  int keepalive_s = 2;   ///< a Marlin at a long command is to say so this often; 0: as it is set
  /// False: once opened, the port is closed without a hang-up, so that opening it again restarts no board.
  bool reset_on_connect = true;
  std::vector<std::filesystem::path> watch;
  bool auto_clear = false;
  std::filesystem::path clock;  ///< empty: the computer's
  PinsConfig pins;
  std::filesystem::path slicer_profile;  ///< instead of the profile of the slicer's section; empty: that
};

struct DaemonConfig {
  std::filesystem::path file;  ///< where it came from; empty for built-in defaults
  std::filesystem::path state_dir = "/var/lib/voidpath";
  std::string listen = "127.0.0.1:8017";
  OrientConfig orient;
  SlicerConfig slicer;
  double settle_s = 1.0;  ///< a dropped file counts once it was closed and has not changed for this long
  std::vector<PrinterConfig> printers;
};

/// What a `MODEL.voidpath.yaml` beside a model, or `.voidpath.yaml` in a watched folder, may say.
struct JobOverrides {
  std::string method;    ///< "" or an orientation method, "as-delivered" included
  std::string slicer;    ///< "" or a slicer's name
  std::string material;
  std::string quality;
  std::optional<double> scale;  ///< empty: not said
  std::optional<int> copies;    ///< empty: not said
  std::vector<std::pair<std::string, std::string>> set;  ///< as --set
};

/// Folders with printers/, materials/, qualities/, first match wins: the user's, /etc/voidpath, the installed
/// share/voidpath, and the source tree's config/ when run from a build.
std::vector<std::filesystem::path> search_path();
/// $VOIDPATH_CONFIG, then ~/.config/voidpath/voidpath.yaml, then /etc/voidpath/voidpath.yaml; empty: none.
std::filesystem::path default_config_file();

/// Refuses watched folders in which a dropped file would be met twice: one that is watched already, also by
/// another name, and the `done` or `failed` of a watched one. Throws ConfigError that names both.
void check_folders(const DaemonConfig& config);

/// Refuses a pin that is given two uses. Throws ConfigError that names both.
void check_pins(const DaemonConfig& config);

/// Throws ConfigError.
DaemonConfig load_daemon(const std::filesystem::path& file);

/// `set` holds "section.key" and value as on the command line (--set slice.perimeters=3,
/// machine.bed_mm=[250,210]). Names may be files. Empty material and quality: pla and 0.20mm, unless the printer's
/// profile says `complete: true`. Throws ConfigError.
Profile load_profile(const std::string& printer, const std::string& material, const std::string& quality,
                     const std::vector<std::pair<std::string, std::string>>& set = {});

/// "PRINTER[,MATERIAL[,QUALITY]]". Throws ConfigError.
Profile load_profile(const std::string& spec, const std::vector<std::pair<std::string, std::string>>& set = {});

/// The resolved profile as YAML: what `voidpath profile show` prints and sha256 is taken of.
std::string profile_text(const Profile& profile);

JobOverrides load_overrides(const std::filesystem::path& file);

/// The search options of the configuration with the limits of the profile's machine.
orient::SearchOptions search_options(const OrientConfig& orient, const Profile& profile);

struct ProfileEntry {
  std::string kind;  ///< "printer", "material", "quality"
  std::string name;
  std::filesystem::path file;
};
std::vector<ProfileEntry> list_profiles();

}  // namespace voidpath::config
