#pragma once

#include <cstdint>
#include <string>
#include <vector>

/// The serial receive buffer: a ring of n holds n − 1 bytes; what does not fit is lost and counted.
namespace voidpath::test::mock {

class RxRing {
 public:
  explicit RxRing(std::size_t size) : bytes_(size < 2 ? 2 : size) {}

  bool empty() const { return head_ == tail_; }
  bool full() const { return head_ - tail_ == bytes_.size() - 1; }
  std::size_t size() const { return head_ - tail_; }
  std::size_t capacity() const { return bytes_.size() - 1; }
  /// False when the byte was lost.
  bool push(char byte) {
    if (full()) {
      ++dropped_;
      return false;
    }
    bytes_[head_++ % bytes_.size()] = byte;
    return true;
  }
  char pop() { return bytes_[tail_++ % bytes_.size()]; }
  void clear() { tail_ = head_; }
  std::uint64_t dropped() const { return dropped_; }

 private:
  std::vector<char> bytes_;
  std::uint64_t head_ = 0, tail_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace voidpath::test::mock
