#include "engine/run/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>
#include <vector>

namespace voidpath::run {

void parallel_for_workers(const Context& ctx, std::size_t count,
                          const std::function<void(std::size_t, unsigned)>& body, std::size_t grain) {
  grain = std::max<std::size_t>(grain, 1);
  const std::size_t chunks = (count + grain - 1) / grain;
  const auto workers = static_cast<unsigned>(std::min<std::size_t>(ctx.thread_count(), chunks));
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  std::exception_ptr error;
  std::mutex error_mutex;

  auto work = [&](unsigned worker) noexcept {
    try {
      for (;;) {
        const std::size_t begin = next.fetch_add(grain);
        if (begin >= count || failed) return;
        ctx.check();
        for (std::size_t i = begin; i < std::min(begin + grain, count); ++i) body(i, worker);
      }
    } catch (...) {
      const std::lock_guard lock(error_mutex);
      if (!error) error = std::current_exception();
      failed = true;
    }
  };

  if (workers <= 1) {
    work(0);
  } else {
    std::vector<std::jthread> threads;
    threads.reserve(workers - 1);
    for (unsigned w = 1; w < workers; ++w) threads.emplace_back(work, w);
    work(0);
  }
  if (error) std::rethrow_exception(error);
}

void parallel_for(const Context& ctx, std::size_t count, const std::function<void(std::size_t)>& body,
                  std::size_t grain) {
  parallel_for_workers(ctx, count, [&](std::size_t i, unsigned) { body(i); }, grain);
}

}  // namespace voidpath::run
