#pragma once

#include "engine/pipeline/prepare.h"
#include "engine/run/context.h"

#include <functional>

namespace voidpath::pipeline {

/// What is left of a choice's time, counted from its making. The clock is the caller's; without one there is
/// always room. Any thread may ask.
class Budget {
 public:
  /// The options must outlive it.
  explicit Budget(const PrepareOptions& options);

  double spent() const;
  /// What is left, s; never negative.
  double left() const;
  bool limited() const { return static_cast<bool>(now_s_); }
  /// Whether something that takes so long would end in time.
  bool has_room(double seconds) const { return !now_s_ || spent() + seconds < budget_s_; }
  double fraction() const;
  /// The context of work that ends with Stopped when the budget does; the budget must outlive it.
  run::Context within(const run::Context& ctx) const;

 private:
  const std::function<double()>& now_s_;
  double budget_s_;
  double began_;
};

/// Runs work under budget.within(ctx). False when the budget ended it; a stop that the caller of it all asked
/// for goes on as run::Stopped.
bool ended_in_time(const Budget& budget, const run::Context& ctx,
                   const std::function<void(const run::Context&)>& work);

}  // namespace voidpath::pipeline
