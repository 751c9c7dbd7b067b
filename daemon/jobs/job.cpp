#include "daemon/jobs/job.h"

#include <sys/stat.h>

namespace voidpath::daemon {
namespace {

constexpr std::array<std::string_view, kStates> kNames = {
    "received", "preparing", "ready",     "waiting for a clear bed",
    "heating",  "printing",  "paused",    "cancelling",
    "done",     "failed",    "cancelled", "interrupted"};

}  // namespace

std::string_view name_of(State state) noexcept { return kNames[static_cast<std::size_t>(state)]; }

std::optional<State> state_from(std::string_view name) noexcept {
  for (std::size_t i = 0; i < kStates; ++i) {
    if (kNames[i] == name) return static_cast<State>(i);
  }
  return std::nullopt;
}

std::optional<FileId> identify(const std::filesystem::path& file) noexcept {
  struct stat found {};
  if (::stat(file.c_str(), &found) != 0 || !S_ISREG(found.st_mode)) return std::nullopt;
  FileId id;
  id.device = found.st_dev;
  id.inode = found.st_ino;
  id.size = static_cast<std::uint64_t>(found.st_size);
  id.mtime_ns = std::int64_t{found.st_mtim.tv_sec} * 1'000'000'000 + found.st_mtim.tv_nsec;
  return id;
}

}  // namespace voidpath::daemon
