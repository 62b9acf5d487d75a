#include "server/sessions/walk.h"

#include <algorithm>

namespace stiefel::server {

bool Walk::advance(std::int64_t to, std::int64_t& budget) {
  std::int64_t at = simulation_->step();
  if (simulation_->direct() && at < to && ending_.reached()) {  // no checkpoint would be nearer
    if (budget <= 0) return false;
    ending_ = simulation_->advance(to - at);
    ++computed_;
    --budget;
    return true;
  }
  while (at < to) {
    if (!ending_.reached()) return true;
    if (budget <= 0) return false;
    const std::int64_t steps = std::min({to - at, budget, mark_ - at});
    ending_ = simulation_->advance(steps);
    const std::int64_t done = simulation_->step() - at;
    at += done;
    computed_ += done;
    budget -= std::max<std::int64_t>(done, 1);
    if (at == mark_) {
      session_->deposit(*simulation_);
      mark_ = session_->next_checkpoint(at);
    }
  }
  return true;
}

}  // namespace stiefel::server
