#include "server/sessions/ledger.h"

#include <utility>

namespace stiefel::server {

void Receipt::then(Done done) {
  {
    const std::lock_guard lock(mutex_);
    if (!settled_) {
      waiting_.push_back(std::move(done));
      return;
    }
  }
  done(fault_);
}

void Receipt::settle(std::optional<WriteFault> fault) noexcept {
  std::vector<Done> waiting;
  {
    const std::lock_guard lock(mutex_);
    fault_ = std::move(fault);
    settled_ = true;
    waiting.swap(waiting_);
  }
  for (const Done& done : waiting) done(fault_);
}

}  // namespace stiefel::server
