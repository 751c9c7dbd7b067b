#include "tests/mock_printer/virtual_clock.h"

#include <atomic>
#include <bit>
#include <cerrno>
#include <cstring>
#include <limits>
#include <system_error>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace voidpath::test::mock {
namespace {

constexpr std::size_t kSize = 16;
static_assert(std::endian::native == std::endian::little, "the file is little-endian");

}  // namespace

ClockFile::ClockFile(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) throw std::system_error(errno, std::generic_category(), "clock file " + path);
  void* map = MAP_FAILED;
  if (::ftruncate(fd, kSize) == 0) map = ::mmap(nullptr, kSize, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  const int error = errno;
  ::close(fd);
  if (map == MAP_FAILED) throw std::system_error(error, std::generic_category(), "clock file " + path);
  words_ = static_cast<std::uint64_t*>(map);
  publish(0);
  std::memcpy(words_, "VPCLOCK1", 8);
}

ClockFile::~ClockFile() { ::munmap(words_, kSize); }

void ClockFile::publish(double seconds) noexcept {
  std::atomic_ref<std::uint64_t>(words_[1]).store(std::bit_cast<std::uint64_t>(seconds),
                                                  std::memory_order_release);
}

double Pacer::allowance(double wall, bool waiting, bool idle, std::uint64_t progress) {
  const double passed = last_wall_ < 0 ? 0 : wall - last_wall_;
  last_wall_ = wall;
  const bool stood = holding_;
  if (progress != progress_) {
    progress_ = progress;
    held_ = 0;
  }
  if (speed_ == 1) return passed;
  if (stood) held_ += passed;
  holding_ = waiting && held_ < grace_s_;
  if (holding_ || stood) return 0;
  if (speed_ > 0) return passed * speed_;
  if (waiting && idle) return passed * kIdleSpeed;
  return std::numeric_limits<double>::infinity();
}

}  // namespace voidpath::test::mock
