#include "server/service/walk_call.h"

#include <utility>

#include "server/service/errors.h"

namespace stiefel::server {

WalkCall::WalkCall(Host& host, CallLog log, Hold session, std::int64_t to, Answer answer)
    : host_(host),
      log_(std::move(log)),
      session_(std::move(session)),
      to_(to),
      answer_(std::move(answer)) {
  host_.lifecycle.enter();
  host_.pool_for((*session_)->step_cost()).submit(this);
}

bool WalkCall::run_slice() noexcept {
  try {
    if (cancelled_) {
      finish(errors::cancelled());
    } else if (walk_on()) {
      finish(answer_(**session_, *walk_));
    } else {
      return true;
    }
  } catch (...) {
    finish(errors::from_current_exception());
  }
  return false;
}

bool WalkCall::walk_on() {
  if (!walk_) walk_.emplace(**session_, to_);
  std::int64_t budget = slice_steps((*session_)->step_cost());
  if (!host_.lifecycle.stopping()) return walk_->advance(to_, budget);
  if (walk_->step() < to_) walk_->cancel();
  return true;
}

void WalkCall::finish(const grpc::Status& status) {
  log_.finish(status, walk_ ? walk_->computed_steps() : 0);
  walk_.reset();
  session_.reset();
  Finish(status);
}

void WalkCall::OnDone() {
  Host& host = host_;
  delete this;
  host.lifecycle.leave();
}

PooledCall::PooledCall(Host& host, Pool& pool, CallLog log, Work work)
    : host_(host),
      log_(std::move(log)),
      work_(std::move(work)),
      shutdown_(host.lifecycle.stop_token(), RequestStop{stop_}) {
  host_.lifecycle.enter();
  pool.submit(this);
}

bool PooledCall::run_slice() noexcept {
  grpc::Status status;
  try {
    status = work_(stop_.get_token());
  } catch (...) {
    status = errors::from_current_exception();
  }
  log_.finish(status);
  Finish(status);
  return false;
}

void PooledCall::OnDone() {
  Host& host = host_;
  delete this;
  host.lifecycle.leave();
}

}  // namespace stiefel::server
