#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace voidpath::cli {

struct CorpusModel {
  std::string name;  ///< as the folder or the manifest has it
  std::filesystem::path file;
  double scale = 1.0;
};

/// The models of a folder, by name, or those that a CSV file lists: column `file` (relative to the CSV's own
/// folder) and, where there is one, `scale`. A folder's models get their scales from a MANIFEST.csv in it.
/// Throws UsageError naming file and line.
std::vector<CorpusModel> list_corpus(const std::filesystem::path& folder_or_csv);

}  // namespace voidpath::cli
