#include "engine/run/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace voidpath::run {

namespace {

/// Whether all threads do well, and the first exception if not.
class Outcome {
 public:
  template <class Work>
  void guard(Work&& work) noexcept {
    try {
      work();
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!error_) error_ = std::current_exception();
      failed_ = true;
    }
  }
  bool failed() const { return failed_; }
  /// After all threads have ended.
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  std::atomic<bool> failed_{false};
  std::exception_ptr error_;
  std::mutex mutex_;
};

/// work(0) here, the others on threads of their own, as many as the system gives.
template <class Work>
void on_threads(std::size_t workers, const Work& work) {
  std::vector<std::jthread> threads;
  try {
    for (std::size_t w = 1; w < workers; ++w) threads.emplace_back(work, static_cast<unsigned>(w));
  } catch (const std::system_error&) {
    // Those that run do it all.
  }
  work(0u);
}

}  // namespace

void parallel_for_workers(const Context& ctx, std::size_t count,
                          const std::function<void(std::size_t, unsigned)>& body, std::size_t grain) {
  grain = std::max<std::size_t>(grain, 1);
  const std::size_t chunks = (count + grain - 1) / grain;
  std::atomic<std::size_t> next{0};
  Outcome outcome;
  const auto work = [&](unsigned worker) noexcept {
    outcome.guard([&] {
      for (;;) {
        const std::size_t begin = next.fetch_add(grain);
        if (begin >= count || outcome.failed()) return;
        ctx.check();
        for (std::size_t i = begin; i < std::min(begin + grain, count); ++i) body(i, worker);
      }
    });
  };
  on_threads(std::min<std::size_t>(ctx.thread_count(), chunks), work);
  outcome.rethrow();
}

void parallel_for(const Context& ctx, std::size_t count, const std::function<void(std::size_t)>& body,
                  std::size_t grain) {
  parallel_for_workers(
      ctx, count, [&](std::size_t i, unsigned) { body(i); }, grain);
}

void parallel_after(const Context& ctx, std::size_t count, const std::function<void(std::size_t)>& link,
                    const std::function<void(std::size_t)>& body) {
  std::atomic<std::size_t> linked{0};
  std::atomic<std::size_t> next{0};
  Outcome outcome;
  const auto follow = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      for (std::size_t seen = linked; seen <= i; seen = linked) linked.wait(seen);
      if (outcome.failed()) return;
      ctx.check();
      body(i);
    }
  };
  const auto work = [&](unsigned worker) noexcept {
    if (worker == 0) {
      outcome.guard([&] {
        for (std::size_t i = 0; i < count && !outcome.failed(); ++i) {
          ctx.check();
          link(i);
          linked = i + 1;
          linked.notify_all();
        }
      });
      // After a failure nobody waits any longer.
      linked = count;
      linked.notify_all();
    }
    outcome.guard(follow);
  };
  on_threads(std::min<std::size_t>(ctx.thread_count(), count), work);
  outcome.rethrow();
}

void parallel_before(const Context& ctx, std::size_t count, const std::function<void(std::size_t)>& body,
                     const std::function<void(std::size_t)>& link) {
  std::vector<std::atomic<char>> done(count);
  std::atomic<std::size_t> next{0};
  Outcome outcome;
  const auto finish = [&](std::size_t i) {
    done[i] = 1;
    done[i].notify_one();
  };
  // Whether there was one left to do.
  const auto do_next = [&] {
    const std::size_t i = next++;
    if (i >= count || outcome.failed()) return false;
    ctx.check();
    body(i);
    finish(i);
    return true;
  };
  const auto in_order = [&] {
    for (std::size_t i = 0; i < count; ++i) {
      while (done[i] == 0 && do_next()) {
      }
      done[i].wait(0);
      if (outcome.failed()) return;
      ctx.check();
      link(i);
    }
  };
  const auto work = [&](unsigned worker) noexcept {
    outcome.guard([&] {
      if (worker == 0) return in_order();
      while (do_next()) {
      }
    });
    // After a failure nobody waits any longer.
    for (std::size_t i = 0; i < count && outcome.failed(); ++i) finish(i);
  };
  on_threads(std::min<std::size_t>(ctx.thread_count(), count), work);
  outcome.rethrow();
}

}  // namespace voidpath::run
