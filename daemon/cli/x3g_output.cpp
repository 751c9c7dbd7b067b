#include "daemon/cli/x3g_output.h"

#include "daemon/jobs/s3g_machine.h"
#include "firmware-io/printer_port.h"
#include "firmware-io/s3g/x3g_file.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>

namespace voidpath::cli {

namespace fs = std::filesystem;

namespace {

/// A file that is gone when its keeper is, unless it was renamed.
struct Remover {
  fs::path file;
  ~Remover() {
    std::error_code ignored;
    fs::remove(file, ignored);
  }
};

}  // namespace

bool is_x3g_name(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".x3g";
}

std::vector<std::string> convert_to_x3g(const fs::path& gcode, const fs::path& out,
                                        const config::Profile& profile) {
  const Remover sliced{gcode};
  const Remover part{fs::path(out) += ".part"};
  std::vector<std::string> notes;
  try {
    std::ofstream file(part.file, std::ios::binary | std::ios::trunc);
    if (!file) throw std::runtime_error(std::strerror(errno));
    notes = fw::s3g::write_x3g(*fw::open_gcode_file(gcode.string()), daemon::s3g_machine(profile),
                               out.stem().string(), file);
    file.close();
    if (!file) throw std::runtime_error("the file could not be written");
    fs::rename(part.file, out);
  } catch (const std::exception& error) {
    throw std::runtime_error(out.string() + ": " + error.what());
  }
  return notes;
}

}  // namespace voidpath::cli
