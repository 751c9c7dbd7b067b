#include "config/tree.h"

#include <fstream>
#include <set>
#include <sstream>

#include <yaml-cpp/yaml.h>

#include "config/config.h"

namespace voidpath::config {

namespace {

/// Deeper nesting than any configuration has; keeps a hostile file from exhausting the stack.
constexpr int kMaxDepth = 20;

Tree convert(const YAML::Node& node, const std::string& name, int depth) {
  Tree tree;
  tree.line = node.Mark().line + 1;
  const auto place = [&](int line) { return name + ":" + std::to_string(line) + ": "; };
  if (depth > kMaxDepth) throw ConfigError(place(tree.line) + "nested too deeply");
  switch (node.Type()) {
    case YAML::NodeType::Scalar:
      tree.kind = Tree::Kind::scalar;
      tree.scalar = node.Scalar();
      break;
    case YAML::NodeType::Sequence:
      tree.kind = Tree::Kind::list;
      for (const auto& item : node) tree.list.push_back(convert(item, name, depth + 1));
      break;
    case YAML::NodeType::Map: {
      tree.kind = Tree::Kind::map;
      std::set<std::string> seen;
      for (const auto& item : node) {
        const int line = item.first.Mark().line + 1;
        if (!item.first.IsScalar()) throw ConfigError(place(line) + "a key must be a word");
        if (!seen.insert(item.first.Scalar()).second)
          throw ConfigError(place(line) + "'" + item.first.Scalar() + "' is given twice");
        tree.map.push_back({item.first.Scalar(), line, convert(item.second, name, depth + 1)});
      }
      break;
    }
    default:
      break;
  }
  return tree;
}

}  // namespace

Tree read_yaml_text(const std::string& text, const std::string& name) {
  try {
    return convert(YAML::Load(text), name, 0);
  } catch (const YAML::Exception& e) {
    const std::string place = e.mark.is_null() ? name : name + ":" + std::to_string(e.mark.line + 1);
    throw ConfigError(place + ": not valid YAML: " + e.msg);
  }
}

Tree read_yaml_file(const std::filesystem::path& file) {
  std::error_code ec;
  if (std::filesystem::is_directory(file, ec)) throw ConfigError(file.string() + ": is a folder, not a file");
  std::ifstream in(file, std::ios::binary);
  if (!in) throw ConfigError(file.string() + ": cannot be read");
  std::ostringstream text;
  text << in.rdbuf();
  return read_yaml_text(text.str(), file.string());
}

std::string yaml_scalar(const std::string& text) {
  YAML::Emitter out;
  if (text.find('\n') != std::string::npos)
    out << YAML::Literal << text;
  else
    out << text;
  return out.c_str();
}

}  // namespace voidpath::config
