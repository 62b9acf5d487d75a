#include "server/calls/cursor_call.h"

#include <utility>

#include "server/calls/stopped.h"
#include "server/convert/errors.h"
#include "server/sessions/stoppable.h"

namespace stiefel::server {

CursorCall::CursorCall(Host& host, CallLog log, SessionLease session, std::int64_t to,
                       Search search, bool long_search)
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

CursorCall::CursorCall(Host& host, CallLog log, SessionLease session, std::int64_t to,
                       Answer answer)
    : CursorCall(
          host, std::move(log), std::move(session), to,
          [answer = std::move(answer)](const Session& at, const Cursor& cursor,
                                       const std::stop_token&) { return answer(at, cursor); },
          false) {}

CursorCall::CursorCall(Host& host, CallLog log, SessionLease session, std::int64_t to,
                       Search search)
    : CursorCall(
          host, std::move(log), std::move(session), to,
          [&host, search = std::move(search)](const Session& at, const Cursor& cursor,
                                              const std::stop_token& stop) {
            const auto status = stoppable(stop, [&] { return search(at, cursor, stop); });
            // What was left out because of a stop is no answer.
            return status && !stop.stop_requested() ? *status : stopped(host.lifecycle);
          },
          true) {}

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
    const std::stop_token stop = stop_.get_token();
    status = stoppable(stop, [&] { return work_(stop); }).value_or(stopped(host_.lifecycle));
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
