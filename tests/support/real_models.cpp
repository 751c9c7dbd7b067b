#include "tests/support/real_models.h"

#include "engine/mesh/import.h"

#include <algorithm>
#include <charconv>
#include <fstream>

namespace voidpath::test {

namespace fs = std::filesystem;

namespace {

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> out(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      out.emplace_back();
    else if (c != '\r')
      out.back() += c;
  }
  return out;
}

std::map<std::string, double> scales_in(const fs::path& folder) {
  std::map<std::string, double> out;
  for (const Row& row : read_csv(folder / "MANIFEST.csv")) {
    const auto file = row.find("file"), scale = row.find("scale");
    if (file == row.end() || scale == row.end()) continue;
    double value = 1;
    std::from_chars(scale->second.data(), scale->second.data() + scale->second.size(), value);
    out[file->second] = value;
  }
  return out;
}

double scale_of(const std::map<std::string, double>& scales, const fs::path& file) {
  const auto found = scales.find(file.filename().string());
  return found == scales.end() ? 1 : found->second;
}

}  // namespace

std::vector<Row> read_csv(const fs::path& file) {
  std::ifstream in(file);
  std::vector<Row> rows;
  std::vector<std::string> heading;
  for (std::string line; std::getline(in, line);) {
    const std::vector<std::string> cells = cells_of(line);
    if (heading.empty()) {
      heading = cells;
      continue;
    }
    Row& row = rows.emplace_back();
    for (std::size_t i = 0; i < heading.size() && i < cells.size(); ++i) row[heading[i]] = cells[i];
  }
  return rows;
}

std::vector<RealModel> real_models(const fs::path& folder, std::string_view part) {
  const auto scales = scales_in(folder);
  std::vector<RealModel> out;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path& file = entry.path();
    if (mesh::is_model_name(file) && file.filename().string().find(part) != std::string::npos)
      out.push_back({file, scale_of(scales, file)});
  }
  std::sort(out.begin(), out.end(), [](const RealModel& a, const RealModel& b) { return a.file < b.file; });
  return out;
}

RealModel real_model(const fs::path& file) { return {file, scale_of(scales_in(file.parent_path()), file)}; }

}  // namespace voidpath::test
