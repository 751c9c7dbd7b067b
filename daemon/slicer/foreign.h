#pragma once

#include "config/config.h"
#include "engine/pipeline/prepare.h"

#include <string>
#include <string_view>
#include <vector>

/// Slicers that are installed beside us, run on the part that we have turned and placed.
namespace voidpath::daemon {

/// The slicer of the configuration for a printer, ready to be called; empty for the built-in one. `named`:
/// the job's own wish, empty for the configuration's; `profile`: instead of the one in the configuration,
/// unless empty. Throws std::runtime_error, with what to do, when the program, its profile or its definition
/// is missing.
pipeline::ForeignSlicer foreign_slicer(const config::SlicerConfig& slicer, const std::string& named,
                                       const std::filesystem::path& profile);

/// The slicing profile's hash where a foreign slicer has a say: its files, its name and ours. Empty `named`:
/// the configuration's. With the built-in slicer, `ours` as it is.
std::string slicing_sha256(const config::SlicerConfig& slicer, const std::string& named,
                           const std::filesystem::path& profile, const std::string& ours);

/// What a slicer said, without its progress: at most kMostMessages lines, the last of them.
inline constexpr std::size_t kMostMessages = 40;
std::vector<std::string> messages_in(const std::filesystem::path& log);

}  // namespace voidpath::daemon
