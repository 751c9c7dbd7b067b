#include "engine/pipeline/budget.h"

#include <algorithm>

namespace voidpath::pipeline {

Budget::Budget(const PrepareOptions& options)
    : now_s_(options.now_s), budget_s_(options.budget_s), began_(now_s_ ? now_s_() : 0) {}

double Budget::spent() const { return now_s_ ? now_s_() - began_ : 0; }

double Budget::left() const { return std::max(0.0, budget_s_ - spent()); }

double Budget::fraction() const { return budget_s_ > 0 ? std::min(1.0, spent() / budget_s_) : 1; }

run::Context Budget::within(const run::Context& ctx) const {
  run::Context inner = ctx;
  if (now_s_) inner.over = [this, outer = ctx.over] { return (outer && outer()) || spent() >= budget_s_; };
  return inner;
}

bool ended_in_time(const Budget& budget, const run::Context& ctx,
                   const std::function<void(const run::Context&)>& work) {
  try {
    work(budget.within(ctx));
    return true;
  } catch (const run::Stopped&) {
    ctx.check();
    return false;
  }
}

}  // namespace voidpath::pipeline
