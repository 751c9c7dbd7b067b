#pragma once

#include "config/config.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

namespace voidpath::test {

/// A folder that is gone at the end.
struct Scratch {
  Scratch() {
    std::string name = (std::filesystem::temp_directory_path() / "voidpath-config-XXXXXX").string();
    dir = ::mkdtemp(name.data());
  }
  ~Scratch() { std::filesystem::remove_all(dir); }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(dir / name) << text;
    return dir / name;
  }
  std::filesystem::path dir;
};

/// What the refusal says; empty: it was not refused.
template <class F>
std::string error_of(F&& f) {
  try {
    f();
  } catch (const config::ConfigError& e) {
    return e.what();
  }
  return "";
}

}  // namespace voidpath::test
