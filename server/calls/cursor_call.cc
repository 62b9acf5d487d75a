#include "server/calls/cursor_call.h"

#include <utility>

#include "server/convert/errors.h"

namespace stiefel::server {

CursorCall::CursorCall(Host& host, CallLog log, SessionLease session, std::int64_t to,
                       Search search, bool long_search, MemoryLease memory)
    : host_(host),
      log_(std::move(log)),
      memory_(std::move(memory)),
      session_(std::move(session)),
      to_(to),
      answer_(std::move(search)),
      search_ahead_(long_search),
      shutdown_(host.lifecycle.stop_token(), RequestStop{stop_}) {
  host_.lifecycle.enter();
  host_.pool_for((*session_)->step_cost()).submit(this);
}

CursorCall::CursorCall(Host& host, CallLog log, SessionLease session, std::int64_t to,
                       Answer answer, MemoryLease memory)
    : CursorCall(
          host, std::move(log), std::move(session), to,
          [answer = std::move(answer)](const Session& at, const Cursor& cursor,
                                       const std::stop_token&) { return answer(at, cursor); },
          false, std::move(memory)) {}

CursorCall::CursorCall(Host& host, CallLog log, SessionLease session, std::int64_t to,
                       Search search, MemoryLease memory)
    : CursorCall(host, std::move(log), std::move(session), to, std::move(search), true,
                 std::move(memory)) {}

bool CursorCall::run_slice() noexcept {
  try {
    if (stop_.stop_requested() && !host_.lifecycle.stopping()) {
      finish(errors::cancelled());
    } else if (walked_ || advance_cursor()) {
      walked_ = true;
      if (std::exchange(search_ahead_, false)) {
        host_.searches.submit(this);
        return false;
      }
      const grpc::Status status = answer_(**session_, *cursor_, stop_.get_token());
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

bool CursorCall::advance_cursor() {
  if (!cursor_) cursor_.emplace(**session_, to_);
  std::int64_t budget = slice_steps((*session_)->step_cost());
  if (!host_.lifecycle.stopping()) return cursor_->advance(to_, budget, stop_.get_token());
  if (cursor_->step() < to_) cursor_->cancel();
  return true;
}

void CursorCall::finish(const grpc::Status& status) {
  log_.finish(status, cursor_ ? cursor_->computed_steps() : 0);
  cursor_.reset();
  session_.reset();
  Finish(status);
}

void CursorCall::OnDone() {
  Host& host = host_;
  delete this;
  host.lifecycle.leave();
}

PooledCall::PooledCall(Host& host, Pool& pool, CallLog log, Work work, MemoryLease memory)
    : host_(host),
      log_(std::move(log)),
      memory_(std::move(memory)),
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
