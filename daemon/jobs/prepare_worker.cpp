#include "daemon/jobs/prepare_worker.h"

#include <atomic>
#include <memory>
#include <utility>

/// The thread of a PrepareWorker runs the engine on one task and ends. It reads the task, writes files below
/// the state directory and posts; it never waits for the loop.
namespace voidpath::daemon {
namespace {

/// Steps of progress that are passed on; more would only keep the loop busy.
constexpr int kProgressSteps = 100;

}  // namespace

PrepareWorker::PrepareWorker(Executor& loop, PrepareFunction work, Done done, Progress progress)
    : loop_(loop), work_(std::move(work)), done_(std::move(done)), progress_(std::move(progress)) {}

PrepareWorker::~PrepareWorker() {
  *alive_ = false;
  stop_.request_stop();
}

void PrepareWorker::start(PrepareTask task) {
  busy_ = true;
  stop_ = std::stop_source();
  const JobId job = task.job;
  auto* loop = &loop_;

  run::Context ctx;
  ctx.stop = stop_.get_token();
  auto last = std::make_shared<std::atomic<int>>(-1);
  ctx.on_progress = [this, loop, job, last, alive = alive_](std::string_view phase, double fraction) {
    const int step = static_cast<int>(fraction * kProgressSteps);
    if (last->exchange(step) == step) return;
    loop->post([this, alive, job, phase = std::string(phase), fraction] {
      if (*alive) progress_(job, phase, fraction);
    });
  };
  // A finished thread is joined here at no cost: it had nothing left to do but return.
  thread_ = std::jthread(
      [this, loop, job, alive = alive_, work = work_, task = std::move(task), ctx = std::move(ctx)] {
        PrepareResult result = work(task, ctx);
        loop->post([this, alive, job, result = std::move(result)]() mutable {
          if (!*alive) return;
          busy_ = false;
          done_(job, std::move(result));
        });
      });
}

}  // namespace voidpath::daemon
