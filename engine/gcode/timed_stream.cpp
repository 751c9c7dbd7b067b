#include "engine/gcode/timed_stream.h"

#include <condition_variable>
#include <deque>
#include <future>
#include <istream>
#include <mutex>
#include <ostream>
#include <streambuf>
#include <string>
#include <utility>

// Two threads: the writer fills a piece of text, hands it to the stream behind and then to the queue; the
// timer takes pieces from the queue in order. Either waits for the other, the writer where it is a few pieces
// ahead, so that memory is bounded. A timer that ends early, by an exception, takes no more: the writer goes
// on without it and learns of it in finish().

namespace voidpath::gcode {
namespace {

/// Text is handed on in pieces of this size, bytes: small beside a print, large beside the cost of doing so.
constexpr std::size_t kPiece = 64 * 1024;
/// Pieces that may wait.
constexpr std::size_t kMostWaiting = 64;

class PieceQueue {
 public:
  /// By the writer.
  void push(std::string piece) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return pieces_.size() < kMostWaiting || deserted_; });
    if (deserted_) return;
    pieces_.push_back(std::move(piece));
    changed_.notify_all();
  }
  /// By the writer: no more will come.
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }
  /// By the timer; false at the end.
  bool pop(std::string& piece) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !pieces_.empty() || closed_; });
    if (pieces_.empty()) return false;
    piece = std::move(pieces_.front());
    pieces_.pop_front();
    changed_.notify_all();
    return true;
  }
  /// By the timer: no more will be taken.
  void desert() {
    const std::lock_guard lock(mutex_);
    deserted_ = true;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::string> pieces_;
  bool closed_ = false;
  bool deserted_ = false;
};

/// The writer's end.
class Entrance : public std::streambuf {
 public:
  Entrance(std::ostream& to, PieceQueue& queue) : to_(to), queue_(queue) { begin_piece(); }

 protected:
  int_type overflow(int_type c) override {
    if (!hand_on()) return traits_type::eof();
    if (!traits_type::eq_int_type(c, traits_type::eof())) {
      *pptr() = traits_type::to_char_type(c);
      pbump(1);
    }
    return traits_type::not_eof(c);
  }
  int sync() override { return hand_on() ? 0 : -1; }

 private:
  void begin_piece() {
    piece_.assign(kPiece, '\0');
    setp(piece_.data(), piece_.data() + piece_.size());
  }
  bool hand_on() {
    const auto size = static_cast<std::size_t>(pptr() - pbase());
    if (size == 0) return static_cast<bool>(to_);
    piece_.resize(size);
    to_.write(piece_.data(), static_cast<std::streamsize>(size));
    queue_.push(std::move(piece_));
    begin_piece();
    return static_cast<bool>(to_);
  }

  std::ostream& to_;
  PieceQueue& queue_;
  std::string piece_;
};

/// The timer's end.
class Exit : public std::streambuf {
 public:
  explicit Exit(PieceQueue& queue) : queue_(queue) {}
  ~Exit() override { queue_.desert(); }

 protected:
  int_type underflow() override {
    if (!queue_.pop(piece_)) return traits_type::eof();
    setg(piece_.data(), piece_.data(), piece_.data() + piece_.size());
    return traits_type::to_int_type(piece_.front());
  }

 private:
  PieceQueue& queue_;
  std::string piece_;
};

}  // namespace

struct TimedStream::Machinery {
  PieceQueue queue;
  Entrance entrance;
  std::ostream stream;
  std::future<Estimate> estimate;

  Machinery(std::ostream& to, const motion::MachineLimits& limits, const run::Context& ctx)
      : entrance(to, queue),
        stream(&entrance),
        estimate(std::async(std::launch::async, [this, limits, ctx] {
          Exit exit(queue);
          std::istream in(&exit);
          return gcode::estimate(in, limits, ctx);
        })) {}
};

TimedStream::TimedStream(std::ostream& to, const motion::MachineLimits& limits, const run::Context& ctx)
    : machinery_(std::make_unique<Machinery>(to, limits, ctx)) {}

TimedStream::~TimedStream() { machinery_->queue.close(); }

std::ostream& TimedStream::stream() { return machinery_->stream; }

Estimate TimedStream::finish() {
  machinery_->stream.flush();
  machinery_->queue.close();
  return machinery_->estimate.get();
}

}  // namespace voidpath::gcode
