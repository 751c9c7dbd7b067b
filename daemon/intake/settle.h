#pragma once

#include "daemon/intake/file_checks.h"
#include "daemon/jobs/job.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

namespace voidpath::daemon {

/// A file that is complete as far as anyone can tell.
struct StableFile {
  std::filesystem::path path;
  FileId id;
};

/// How a Settler looks at files; tests bring their own.
struct FileProbe {
  std::function<std::optional<FileId>(const std::filesystem::path&)> identify;
  std::function<bool(const std::filesystem::path&)> open_for_writing;
  std::function<Completeness(const std::filesystem::path&)> completeness;
};
FileProbe real_probe();

/// How long a file that itself says that it is not complete is waited for after its last change, s. A copy
/// over a poor network pauses that long; then it is taken, and refused with what is wrong with it.
inline constexpr double kTruncatedPatience_s = 75;
/// Likewise for a text whose last line has no end: some programs write none.
inline constexpr double kUnendedPatience_s = 15;

/// Waits until dropped files are complete: unchanged for `settle_s`, nobody has them open for writing, and
/// their content promises no more than is there. Pure but for the probe; loop thread only.
class Settler {
 public:
  Settler(double settle_s, FileProbe probe) : settle_s_(settle_s), probe_(std::move(probe)) {}

  /// The file was seen, closed, moved in or changed.
  void note(const std::filesystem::path& file, double now_s);
  /// Those that have settled by now, in the order they were first noted. Vanished ones are forgotten.
  std::vector<StableFile> poll(double now_s);
  bool pending(const std::filesystem::path& file) const;
  bool idle() const noexcept { return waiting_.empty(); }
  std::vector<std::filesystem::path> files() const;

 private:
  struct Entry {
    std::filesystem::path path;
    std::optional<FileId> id;
    double since_s = 0;  ///< last seen changing, or in a writer's hands
  };
  bool settled(const Entry& entry, double quiet_s) const;
  std::vector<Entry> waiting_;
  double settle_s_;
  FileProbe probe_;
};

}  // namespace voidpath::daemon
