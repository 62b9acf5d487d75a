#include "server/service/walk_call.h"

#include <utility>

#include "server/service/errors.h"

namespace stiefel::server {

WalkCall::WalkCall(Host& host, CallLog log, Hold session, std::int64_t to, Search search,
                   bool long_search)
    : host_(host),
      log_(std::move(log)),
      session_(std::move(session)),
      to_(to),
      answer_(std::move(search)),
      search_ahead_(long_search),
      shutdown_(host.lifecycle.stop_token(), RequestStop{stop_}) {
  host_.lifecycle.enter();
  host_.pool_for((*session_)->step_cost()).submit(this);
}

WalkCall::WalkCall(Host& host, CallLog log, Hold session, std::int64_t to, Answer answer)
    : WalkCall(
          host, std::move(log), std::move(session), to,
          [answer = std::move(answer)](const Session& at, const Walk& walk,
                                       const std::stop_token&) { return answer(at, walk); },
          false) {}

WalkCall::WalkCall(Host& host, CallLog log, Hold session, std::int64_t to, Search search)
    : WalkCall(host, std::move(log), std::move(session), to, std::move(search), true) {}

bool WalkCall::run_slice() noexcept {
  try {
    if (stop_.stop_requested() && !host_.lifecycle.stopping()) {
      finish(errors::cancelled());
    } else if (walked_ || walk_on()) {
      walked_ = true;
      if (std::exchange(search_ahead_, false)) {
        host_.searches.submit(this);
        return false;
      }
      const grpc::Status status = answer_(**session_, *walk_, stop_.get_token());
      const bool left = stop_.stop_requested() && !host_.lifecycle.stopping();
      finish(left ? errors::cancelled() : status);
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
