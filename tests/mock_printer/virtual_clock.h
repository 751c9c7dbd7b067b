#pragma once

#include <cstdint>
#include <string>

/// The printer's clock, published in a small file that others map: 8 bytes "VPCLOCK1", then its seconds as a
/// little-endian double.
namespace voidpath::test::mock {

class ClockFile {
 public:
  /// Creates and maps the file (0 s). Throws std::system_error.
  explicit ClockFile(const std::string& path);
  ~ClockFile();
  ClockFile(const ClockFile&) = delete;
  ClockFile& operator=(const ClockFile&) = delete;
  void publish(double seconds) noexcept;

 private:
  std::uint64_t* words_ = nullptr;
};

/// How wall time becomes printer time. Pure; the caller supplies wall times (s).
///
/// While the printer waits for its host the clock stands, until the wait has used up the grace; then it runs
/// on. The grace is refilled when the print goes on. A clock at normal speed never stands.
class Pacer {
 public:
  /// `speed` 0: as fast as it can.
  Pacer(double speed, double grace_s) : speed_(speed), grace_s_(grace_s) {}

  /// Told at every turn of the loop. `waiting`: the printer has answered all and could use more; `progress`:
  /// a number that changes when the print goes on. Returns how far the clock may go, s of its own (infinity:
  /// to whatever comes next).
  double allowance(double wall, bool waiting, bool idle, std::uint64_t progress);
  /// Whether the clock stood at the last turn.
  bool holding() const { return holding_; }
  /// Wall seconds until the hold ends.
  double grace_left() const { return grace_s_ - held_; }
  double speed() const { return speed_; }

 private:
  double speed_, grace_s_;
  double last_wall_ = -1;
  double held_ = 0;
  std::uint64_t progress_ = 0;
  bool holding_ = false;
};

/// How fast a clock that runs as fast as it can goes while nothing moves and the host is silent.
inline constexpr double kIdleSpeed = 100;

}  // namespace voidpath::test::mock
