#pragma once

#include "daemon/jobs/runner.h"
#include "daemon/json/json.h"

#include <memory>
#include <mutex>
#include <utility>

namespace voidpath::daemon {

/// What users see of the daemon at one moment. Never changes once published.
struct Snapshot {
  Json status;
  Json queue;
};

/// Loop thread.
Snapshot make_snapshot(const Runner& runner, const Settler& settler);
Json job_json(const Job& job);

/// The latest snapshot, handed from the loop to the HTTP threads. Any thread.
class SnapshotBox {
 public:
  void put(Snapshot snapshot) {
    auto next = std::make_shared<const Snapshot>(std::move(snapshot));
    const std::lock_guard lock(mutex_);
    snapshot_ = std::move(next);
  }
  std::shared_ptr<const Snapshot> get() const {
    const std::lock_guard lock(mutex_);
    return snapshot_;
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const Snapshot> snapshot_ = std::make_shared<const Snapshot>();
};

}  // namespace voidpath::daemon
