#include "daemon/intake/folder_watcher.h"

#include "daemon/intake/file_checks.h"
#include "daemon/jobs/job.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

namespace voidpath::daemon {
namespace {

namespace fs = std::filesystem;

/// IN_CREATE for files that are linked in: those are never closed. The settling sees to it that a file
/// that was merely begun is not taken.
constexpr std::uint32_t kEvents =
    IN_CLOSE_WRITE | IN_MOVED_TO | IN_CREATE | IN_DELETE_SELF | IN_MOVE_SELF | IN_ONLYDIR;

}  // namespace

FolderWatcher::FolderWatcher(std::vector<fs::path> folders, Found found, Trouble trouble)
    : fd_(inotify_init1(IN_CLOEXEC | IN_NONBLOCK)), found_(std::move(found)), trouble_(std::move(trouble)) {
  if (fd_ < 0) throw std::system_error(errno, std::generic_category(), "inotify_init1");
  for (auto& folder : folders) folders_.push_back({std::move(folder), -1, 0, false});
}

FolderWatcher::~FolderWatcher() { ::close(fd_); }

void FolderWatcher::attach(Folder& folder) {
  std::error_code error;
  fs::create_directories(folder.path, error);
  const int watch = inotify_add_watch(fd_, folder.path.c_str(), kEvents);
  struct stat found {};
  if (watch < 0 || ::stat(folder.path.c_str(), &found) != 0) {
    if (!std::exchange(folder.told, true)) {
      trouble_(folder.path, "cannot be watched (" + std::generic_category().message(errno) +
                                "); create it, or let this user read it: it is tried again");
    }
    return;
  }
  if (folder.told) trouble_(folder.path, "is watched again");
  folder.told = false;
  folder.watch = watch;
  folder.inode = found.st_ino;
  scan(folder);
}

void FolderWatcher::check() {
  for (auto& folder : folders_) {
    struct stat found {};
    const bool there = ::stat(folder.path.c_str(), &found) == 0;
    // Another folder under the same name: something was mounted there, or it was swapped.
    if (folder.watch >= 0 && there && found.st_ino == folder.inode) continue;
    if (folder.watch >= 0) inotify_rm_watch(fd_, folder.watch);
    folder.watch = -1;
    attach(folder);
  }
}

void FolderWatcher::scan(const Folder& folder) {
  std::vector<std::pair<std::int64_t, fs::path>> files;
  std::error_code error;
  for (auto entry = fs::directory_iterator(folder.path, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    if (input_kind(entry->path()) == InputKind::none) continue;
    if (const auto id = identify(entry->path())) files.emplace_back(id->mtime_ns, entry->path());
  }
  std::sort(files.begin(), files.end());
  for (const auto& [when, file] : files) found_(file);
}

void FolderWatcher::scan_all() {
  for (const auto& folder : folders_) {
    if (folder.watch >= 0) scan(folder);
  }
}

void FolderWatcher::on_readable() {
  alignas(inotify_event) std::array<char, 16384> buffer;
  bool overflow = false;
  for (;;) {
    const ssize_t length = ::read(fd_, buffer.data(), buffer.size());
    if (length <= 0) break;
    for (ssize_t at = 0; at < length;) {
      const auto* event = reinterpret_cast<const inotify_event*>(buffer.data() + at);
      at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
      if ((event->mask & IN_Q_OVERFLOW) != 0) overflow = true;
      const auto folder = std::find_if(folders_.begin(), folders_.end(),
                                       [&](const Folder& one) { return one.watch == event->wd; });
      if (folder == folders_.end()) continue;
      if ((event->mask & (IN_DELETE_SELF | IN_MOVE_SELF | IN_IGNORED | IN_UNMOUNT)) != 0) {
        if ((event->mask & IN_IGNORED) == 0) inotify_rm_watch(fd_, folder->watch);
        folder->watch = -1;
      } else if (event->len > 0 && (event->mask & IN_ISDIR) == 0) {
        const fs::path file = folder->path / event->name;
        if (input_kind(file) != InputKind::none) found_(file);
      }
    }
  }
  check();
  if (overflow) scan_all();
}

}  // namespace voidpath::daemon
