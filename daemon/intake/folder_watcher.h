#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <vector>

namespace voidpath::daemon {

/// Watches folders by inotify and tells of files that were closed, moved or linked in; also of those
/// already there. A folder that is missing, unmounted or recreated is taken up again by check(). Loop
/// thread only.
class FolderWatcher {
 public:
  /// Called with the full path of a candidate, as often as something happens to it.
  using Found = std::function<void(const std::filesystem::path& file)>;
  /// Called with what is worth telling the user.
  using Trouble = std::function<void(const std::filesystem::path& folder, const std::string& what)>;

  FolderWatcher(std::vector<std::filesystem::path> folders, Found found, Trouble trouble);
  ~FolderWatcher();
  FolderWatcher(const FolderWatcher&) = delete;
  FolderWatcher& operator=(const FolderWatcher&) = delete;

  /// Readable when on_readable() has work.
  int fd() const noexcept { return fd_; }
  void on_readable();
  /// Watches what is not watched yet and is there, making missing folders where it may. To be called now
  /// and then.
  void check();
  /// Tells of every candidate in the watched folders, oldest first.
  void scan_all();

 private:
  struct Folder {
    std::filesystem::path path;
    int watch = -1;
    std::uint64_t inode = 0;
    bool told = false;  ///< that it is missing
  };
  void attach(Folder& folder);
  void scan(const Folder& folder);

  int fd_ = -1;
  std::vector<Folder> folders_;
  Found found_;
  Trouble trouble_;
};

}  // namespace voidpath::daemon
