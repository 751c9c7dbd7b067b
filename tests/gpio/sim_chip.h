#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>

#include <sys/stat.h>
#include <unistd.h>

namespace voidpath::test {

inline void write_file(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file);
  if (!(out << text << std::flush)) throw std::runtime_error("cannot write " + file.string());
}

inline std::string read_file(const std::filesystem::path& file) {
  std::string text;
  std::ifstream in(file);
  if (!std::getline(in, text)) throw std::runtime_error("cannot read " + file.string());
  return text;
}

/// A GPIO chip of the kernel's simulator, gone at the end.
class SimChip {
 public:
  explicit SimChip(const std::string& label, unsigned lines = 8,
                   const std::map<unsigned, std::string>& names = {})
      : root_("/sys/kernel/config/gpio-sim/" + label), bank_(root_ / "bank0"), names_(names) {
    std::filesystem::create_directories(bank_);
    write_file(bank_ / "label", label);
    write_file(bank_ / "num_lines", std::to_string(lines));
    for (const auto& [line, name] : names_) {
      std::filesystem::create_directory(bank_ / ("line" + std::to_string(line)));
      write_file(bank_ / ("line" + std::to_string(line)) / "name", name);
    }
    write_file(root_ / "live", "1");
    name_ = read_file(bank_ / "chip_name");
    device_ = std::filesystem::path("/sys/devices/platform") / read_file(root_ / "dev_name") / name_;
  }
  ~SimChip() {
    unplug();
    for (const auto& [line, name] : names_) ::rmdir((bank_ / ("line" + std::to_string(line))).c_str());
    ::rmdir(bank_.c_str());
    ::rmdir(root_.c_str());
  }
  SimChip(const SimChip&) = delete;
  SimChip& operator=(const SimChip&) = delete;

  const std::string& name() const { return name_; }
  std::string path() const { return "/dev/" + name_; }
  /// What is wired to the line drives it so.
  void pull(unsigned line, bool up) { write_file(of(line) / "pull", up ? "pull-up" : "pull-down"); }
  /// The line's electrical level.
  bool level(unsigned line) const { return read_file(of(line) / "value") == "1"; }
  /// The chip vanishes, whoever uses it.
  void unplug() {
    if (live_) write_file(root_ / "live", "0");
    live_ = false;
  }

 private:
  std::filesystem::path of(unsigned line) const { return device_ / ("sim_gpio" + std::to_string(line)); }

  std::filesystem::path root_, bank_, device_;
  std::map<unsigned, std::string> names_;
  std::string name_;
  bool live_ = true;
};

}  // namespace voidpath::test
