#include "daemon/intake/settle.h"

#include <algorithm>

namespace voidpath::daemon {

FileProbe real_probe() {
  return {[](const std::filesystem::path& file) { return identify(file); },
          [](const std::filesystem::path& file) { return open_for_writing(file); },
          [](const std::filesystem::path& file) { return completeness(file); }};
}

void Settler::note(const std::filesystem::path& file, double now_s) {
  for (auto& entry : waiting_) {
    if (entry.path == file) {
      entry.since_s = now_s;
      return;
    }
  }
  waiting_.push_back({file, probe_.identify(file), now_s});
}

bool Settler::pending(const std::filesystem::path& file) const {
  return std::any_of(waiting_.begin(), waiting_.end(),
                     [&](const Entry& entry) { return entry.path == file; });
}

std::vector<std::filesystem::path> Settler::files() const {
  std::vector<std::filesystem::path> out;
  for (const auto& entry : waiting_) out.push_back(entry.path);
  return out;
}

bool Settler::settled(const Entry& entry, double quiet_s) const {
  if (quiet_s < settle_s_) return false;
  if (probe_.completeness(entry.path) != Completeness::truncated) return true;
  const std::string extension = entry.path.extension().string();
  const bool marked = extension.size() == 4 && input_kind(entry.path) == InputKind::model &&
                      extension != ".obj" && extension != ".OBJ";
  return quiet_s >= (marked ? kTruncatedPatience_s : kUnendedPatience_s);
}

std::vector<StableFile> Settler::poll(double now_s) {
  std::vector<StableFile> out;
  std::erase_if(waiting_, [&](Entry& entry) {
    const auto id = probe_.identify(entry.path);
    if (!id) return true;
    if (entry.id != id) {
      entry.id = id;
      entry.since_s = now_s;
      return false;
    }
    if (now_s - entry.since_s < settle_s_) return false;
    if (probe_.open_for_writing(entry.path)) {
      entry.since_s = now_s;
      return false;
    }
    if (!settled(entry, now_s - entry.since_s)) return false;
    out.push_back({entry.path, *id});
    return true;
  });
  return out;
}

}  // namespace voidpath::daemon
