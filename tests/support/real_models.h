#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace voidpath::test {

/// A row of a table: column name to value.
using Row = std::map<std::string, std::string>;

/// Rows of a comma-separated file with a heading; quoted fields may hold commas, but no line breaks.
std::vector<Row> read_csv(const std::filesystem::path& file);

/// A model of somebody's making; of a folder with a MANIFEST.csv, `scale` brings it to the size it is printed
/// in.
struct RealModel {
  std::filesystem::path file;
  double scale = 1;
};

/// Those in a folder whose name holds `part`, by name.
std::vector<RealModel> real_models(const std::filesystem::path& folder, std::string_view part = {});
/// That one, with its scale.
RealModel real_model(const std::filesystem::path& file);

}  // namespace voidpath::test
