#pragma once

#include "firmware-io/s3g/protocol.h"

#include <cstdint>
#include <deque>
#include <optional>

namespace voidpath::fw::s3g {

/// A glance at the firmware's queue: the line counter did not move while the free bytes were asked for.
struct Glance {
  std::uint32_t line = 0;  ///< commands it has taken out of its queue, counted from somewhere
  std::uint32_t free = 0;  ///< bytes
};

/// Knows whether a command whose reply was lost is in the queue, by what the queue holds.
///
/// The queue always holds the last few of all accepted commands, so that the bytes in it tell how many, if
/// their lengths are known; with the line counter that tells how many were accepted. The counter's origin is
/// not known, and firmware forgets to count some commands that are no moves: so it is learned anew at each
/// glance with nothing but moves in the queue, holds as long as only moves follow, and is trusted at all once
/// two such glances with moves in between have agreed.
class Account {
 public:
  void restart() { *this = {}; }
  void accepted(std::size_t bytes, bool is_move);
  /// Something may be in the queue twice.
  void lose_track();
  /// A glance while no command's fate is open.
  void check(const Glance& glance);
  /// Whether a command of that length was accepted beyond those told; empty: the glance cannot tell.
  std::optional<bool> took(const Glance& glance, std::size_t bytes) const;
  /// A glance now would teach something.
  bool wants_check() const noexcept { return !origin_ && !refuted_; }

 private:
  /// Commands in the queue when it holds so many bytes, `extra` being its last one if not 0.
  std::optional<std::size_t> held(std::uint32_t free, std::size_t extra, bool only_moves) const;

  struct Entry {
    std::size_t bytes;
    bool is_move;
  };
  std::deque<Entry> entries_;            ///< the newest, as many as the queue can hold
  std::uint32_t count_ = 0;              ///< accepted in all
  std::optional<std::uint32_t> origin_;  ///< line counter less commands taken
  std::uint32_t origin_taken_ = 0;       ///< of the glance that gave it
  bool proven_ = false;
  bool refuted_ = false;
};

}  // namespace voidpath::fw::s3g
