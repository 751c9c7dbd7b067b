#include "daemon/intake/file_checks.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string_view>

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace voidpath::daemon {
namespace {

/// How far from the end an archive's or a text's end mark is looked for, bytes: a zip's end record with the
/// longest comment.
constexpr std::streamoff kTail = 22 + 65535;
/// More triangles than this are no promise of a binary STL but text where the count would stand.
constexpr std::uint32_t kMaxTriangles = 40'000'000;

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool ends_with_any(std::string_view name, std::initializer_list<std::string_view> endings) {
  return std::any_of(endings.begin(), endings.end(), [&](auto ending) { return name.ends_with(ending); });
}

/// Whether a process has the same inode open with write access; `fd_dir` is its /proc/PID/fd.
bool process_writes(const std::string& process, const struct stat& file) noexcept {
  DIR* dir = ::opendir((process + "/fd").c_str());
  if (dir == nullptr) return false;
  bool found = false;
  while (const dirent* entry = ::readdir(dir)) {
    if (entry->d_name[0] == '.') continue;
    struct stat open_file {};
    const std::string link = process + "/fd/" + entry->d_name;
    if (::stat(link.c_str(), &open_file) != 0) continue;
    if (open_file.st_ino != file.st_ino || open_file.st_dev != file.st_dev) continue;
    std::ifstream info(process + "/fdinfo/" + entry->d_name);
    for (std::string key, value; info >> key >> value;) {
      if (key != "flags:") continue;
      const long flags = std::strtol(value.c_str(), nullptr, 8);
      found = found || (flags & O_ACCMODE) != O_RDONLY;
      break;
    }
    if (found) break;
  }
  ::closedir(dir);
  return found;
}

bool any_process_writes(const struct stat& file) noexcept {
  DIR* dir = ::opendir("/proc");
  if (dir == nullptr) return false;
  bool found = false;
  while (const dirent* entry = ::readdir(dir)) {
    if (std::isdigit(static_cast<unsigned char>(entry->d_name[0])) == 0) continue;
    if (process_writes(std::string("/proc/") + entry->d_name, file)) {
      found = true;
      break;
    }
  }
  ::closedir(dir);
  return found;
}

Completeness stl_completeness(std::ifstream& in, std::uint64_t size, std::string_view head,
                              std::string_view tail) {
  if (size >= 84) {
    std::uint32_t count = 0;
    in.seekg(80);
    in.read(reinterpret_cast<char*>(&count), 4);  // little-endian, as every machine this runs on
    const std::uint64_t promised = 84 + std::uint64_t{50} * count;
    if (promised == size) return Completeness::complete;
    // A text file's bytes 80 to 83 are letters: an absurd count. Only a plausible one is a promise.
    const bool text = head.starts_with("solid") && head.find("facet") != std::string_view::npos;
    if (!text) {
      const bool plausible = count > 0 && count <= kMaxTriangles;
      return plausible && promised > size ? Completeness::truncated : Completeness::unknown;
    }
  }
  if (!head.starts_with("solid")) return Completeness::unknown;  // neither kind: for the importer to refuse
  return lower(std::string(tail)).find("endsolid") != std::string::npos ? Completeness::complete
                                                                        : Completeness::truncated;
}

}  // namespace

InputKind input_kind(const std::filesystem::path& file) {
  const std::string name = lower(file.filename().string());
  if (name.empty() || name.front() == '.' || name.front() == '~' || name.front() == '#')
    return InputKind::none;
  if (ends_with_any(name, {".stl", ".obj", ".3mf"})) return InputKind::model;
  if (ends_with_any(name, {".gcode", ".gco", ".g", ".gx"})) return InputKind::gcode;
  return InputKind::none;
}

bool open_for_writing(const std::filesystem::path& file) noexcept {
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return false;
  struct stat found {};
  ::fstat(fd, &found);
  // Someone who opens the file during the lease has the kernel signal us; SIGURG is ignored by default,
  // SIGIO would end the process.
  ::fcntl(fd, F_SETSIG, SIGURG);
  bool writer = false;
  if (::fcntl(fd, F_SETLEASE, F_RDLCK) == 0) {
    ::fcntl(fd, F_SETLEASE, F_UNLCK);
  } else if (errno == EAGAIN) {
    writer = true;
  } else {
    writer = any_process_writes(found);
  }
  ::close(fd);
  return writer;
}

Completeness completeness(const std::filesystem::path& file) noexcept try {
  const InputKind kind = input_kind(file);
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in || kind == InputKind::none) return Completeness::unknown;
  const std::streamoff size = in.tellg();
  if (size <= 0) return Completeness::truncated;

  std::string head(static_cast<std::size_t>(std::min<std::streamoff>(size, 1024)), '\0');
  in.seekg(0);
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  std::string tail(static_cast<std::size_t>(std::min(size, kTail)), '\0');
  in.seekg(size - static_cast<std::streamoff>(tail.size()));
  in.read(tail.data(), static_cast<std::streamsize>(tail.size()));
  if (!in) return Completeness::unknown;

  if (head.starts_with("PK")) {  // an archive, whatever its name: it ends with a directory
    return tail.rfind("PK\x05\x06") != std::string::npos ? Completeness::complete : Completeness::truncated;
  }
  const std::string extension = lower(file.extension().string());
  if (extension == ".stl") return stl_completeness(in, static_cast<std::uint64_t>(size), head, tail);
  if (extension == ".3mf") return Completeness::unknown;  // no archive: for the importer to refuse
  const char last = tail.back();
  return last == '\n' || last == '\r' ? Completeness::unknown : Completeness::truncated;
} catch (const std::exception&) {
  return Completeness::unknown;
}

}  // namespace voidpath::daemon
