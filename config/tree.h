#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace voidpath::config {

/// A YAML document as plain data, each node with its place.
struct Tree {
  enum class Kind { nothing, scalar, list, map };
  struct Entry;
  Kind kind = Kind::nothing;
  std::string scalar;
  std::vector<Tree> list;
  std::vector<Entry> map;  ///< in the file's order
  int line = 0;            ///< 1-based; 0 when it did not come from a file
};

struct Tree::Entry {
  std::string key;
  int line = 0;
  Tree value;
};

/// Throws ConfigError with file and line for what is not YAML, for a key given twice, and for a file that
/// cannot be read.
Tree read_yaml_file(const std::filesystem::path& file);
/// `name` stands for the file in errors.
Tree read_yaml_text(const std::string& text, const std::string& name);

/// A string as YAML writes it: plain where it can be, quoted or as a block where it must.
std::string yaml_scalar(const std::string& text);

}  // namespace voidpath::config
