#include "firmware-io/clock.h"

#include <bit>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

namespace voidpath::fw {
namespace {

static_assert(std::endian::native == std::endian::little, "the published clock is little-endian");

constexpr char kMagic[] = "VPCLOCK1";
constexpr std::size_t kMagicSize = 8;
constexpr std::size_t kClockFileSize = kMagicSize + sizeof(double);

class SteadyClock final : public Clock {
 public:
  double now_s() const noexcept override {
    timespec t{};
    ::clock_gettime(CLOCK_MONOTONIC, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
};

class MappedClock final : public Clock {
 public:
  explicit MappedClock(const std::filesystem::path& file) {
    const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) throw std::runtime_error(file.string() + ": cannot open the clock: " + std::strerror(errno));
    struct stat info {};
    const bool long_enough = ::fstat(fd, &info) == 0 && info.st_size >= static_cast<off_t>(kClockFileSize);
    map_ = long_enough ? ::mmap(nullptr, kClockFileSize, PROT_READ, MAP_SHARED, fd, 0) : MAP_FAILED;
    ::close(fd);
    if (map_ == MAP_FAILED) throw std::runtime_error(file.string() + ": not a published clock");
    if (std::memcmp(map_, kMagic, kMagicSize) != 0) {
      ::munmap(map_, kClockFileSize);
      throw std::runtime_error(file.string() + ": not a published clock (no " + kMagic + ")");
    }
  }
  ~MappedClock() override { ::munmap(map_, kClockFileSize); }
  MappedClock(const MappedClock&) = delete;
  MappedClock& operator=(const MappedClock&) = delete;

  double now_s() const noexcept override {
    const auto* bits = reinterpret_cast<const std::uint64_t*>(static_cast<const char*>(map_) + kMagicSize);
    return std::bit_cast<double>(__atomic_load_n(bits, __ATOMIC_ACQUIRE));
  }

 private:
  void* map_ = MAP_FAILED;
};

}  // namespace

std::shared_ptr<const Clock> steady_clock() {
  static const auto clock = std::make_shared<const SteadyClock>();
  return clock;
}

std::shared_ptr<const Clock> mapped_clock(const std::filesystem::path& file) {
  return std::make_shared<const MappedClock>(file);
}

}  // namespace voidpath::fw
