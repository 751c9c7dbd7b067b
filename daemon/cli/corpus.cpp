#include "daemon/cli/corpus.h"

#include "config/fields.h"
#include "engine/evaluate/csv.h"
#include "daemon/cli/offline.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>

namespace voidpath::cli {

namespace fs = std::filesystem;

namespace {

std::string read_text(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw UsageError(file.string() + ": cannot be opened");
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::vector<CorpusModel> read_manifest(const fs::path& csv) {
  const std::vector<evaluate::CsvRow> rows = evaluate::parse_csv(read_text(csv));
  const auto fail = [&](std::size_t line, const std::string& what) -> UsageError {
    return UsageError(csv.string() + ":" + std::to_string(line) + ": " + what);
  };
  if (rows.empty()) throw fail(1, "is empty; a first line that names the columns is wanted");
  const auto column = [&](const char* name) {
    const auto& cells = rows.front().cells;
    return static_cast<std::size_t>(std::find(cells.begin(), cells.end(), name) - cells.begin());
  };
  const std::size_t file = column("file");
  const std::size_t scale = column("scale");
  if (file == rows.front().cells.size()) throw fail(1, "there is no column 'file'");

  std::vector<CorpusModel> out;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const auto& [cells, line] = rows[i];
    if (file >= cells.size() || cells[file].empty()) throw fail(line, "no file is named");
    CorpusModel model{cells[file], csv.parent_path() / cells[file], 1.0};
    if (scale < cells.size() && !cells[scale].empty()) {
      try {
        model.scale = config::parse_number(cells[scale]);
      } catch (const std::invalid_argument& e) {
        throw fail(line, std::string("scale: ") + e.what());
      }
      if (!(model.scale > 0)) throw fail(line, "scale " + cells[scale] + ": a positive number is wanted");
    }
    out.push_back(std::move(model));
  }
  return out;
}

std::vector<CorpusModel> read_folder(const fs::path& folder) {
  std::map<std::string, double> scales;
  const fs::path manifest = folder / "MANIFEST.csv";
  if (fs::exists(manifest))
    for (const CorpusModel& m : read_manifest(manifest)) scales[m.name] = m.scale;
  std::vector<CorpusModel> out;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (!entry.is_regular_file() || !mesh::is_model_name(entry.path())) continue;
    const std::string name = entry.path().filename().string();
    const auto scale = scales.find(name);
    out.push_back({name, entry.path(), scale == scales.end() ? 1.0 : scale->second});
  }
  std::sort(out.begin(), out.end(),
            [](const CorpusModel& a, const CorpusModel& b) { return a.name < b.name; });
  return out;
}

}  // namespace

std::vector<CorpusModel> list_corpus(const fs::path& folder_or_csv) {
  if (!fs::exists(folder_or_csv))
    throw UsageError(folder_or_csv.string() + ": there is no such folder or file");
  auto models = fs::is_directory(folder_or_csv) ? read_folder(folder_or_csv) : read_manifest(folder_or_csv);
  if (models.empty()) throw UsageError(folder_or_csv.string() + ": holds no models");
  return models;
}

}  // namespace voidpath::cli
