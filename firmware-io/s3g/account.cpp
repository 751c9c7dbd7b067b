#include "firmware-io/s3g/account.h"

namespace voidpath::fw::s3g {
namespace {

/// The shortest command has two bytes.
constexpr std::size_t kMostEntries = kQueueBytes / 2 + 1;

}  // namespace

void Account::accepted(std::size_t bytes, bool is_move) {
  entries_.push_back({bytes, is_move});
  if (entries_.size() > kMostEntries) entries_.pop_front();
  ++count_;
  if (!is_move) origin_.reset();
}

void Account::lose_track() {
  entries_.clear();
  origin_.reset();
}

std::optional<std::size_t> Account::held(std::uint32_t free, std::size_t extra, bool only_moves) const {
  if (free > kQueueBytes) return {};
  std::size_t left = kQueueBytes - free;
  if (left == 0) return 0;
  std::size_t n = 0;
  if (extra > 0) {
    if (extra > left) return {};
    left -= extra;
    ++n;
  }
  for (auto entry = entries_.rbegin(); left > 0; ++entry) {
    if (entry == entries_.rend() || entry->bytes > left || (only_moves && !entry->is_move)) return {};
    left -= entry->bytes;
    ++n;
  }
  return n;
}

void Account::check(const Glance& glance) {
  const auto in_queue = held(glance.free, 0, true);
  if (!in_queue) return;
  const std::uint32_t taken = count_ - static_cast<std::uint32_t>(*in_queue);
  const std::uint32_t origin = glance.line - taken;
  if (origin_ && taken != origin_taken_) {
    if (origin == *origin_) {
      proven_ = true;
    } else {
      refuted_ = !proven_;
    }
  }
  origin_ = origin;
  origin_taken_ = taken;
}

std::optional<bool> Account::took(const Glance& glance, std::size_t bytes) const {
  if (!origin_ || !proven_ || refuted_) return {};
  const std::uint32_t taken = glance.line - *origin_;
  const auto without = held(glance.free, 0, false);
  const auto with = held(glance.free, bytes, false);
  // An empty queue fits both; then what was taken decides.
  const bool not_taken = without && count_ - static_cast<std::uint32_t>(*without) == taken;
  const bool taken_in = with && count_ + 1 - static_cast<std::uint32_t>(*with) == taken;
  if (not_taken == taken_in) return {};
  return taken_in;
}

}  // namespace voidpath::fw::s3g
