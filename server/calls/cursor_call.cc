#include "server/calls/cursor_call.h"

#include <algorithm>
#include <utility>

#include "server/admission/admission.h"
#include "server/calls/stopped.h"
#include "server/convert/errors.h"
#include "server/scheduling/failpoint.h"
#include "server/sessions/cursor.h"

namespace stiefel::server {

CursorCall::CursorCall(Host& host, CallLog log, SessionLease session, std::int64_t to,
                       Search search, const Rest& rest, MemoryLease memory)
    : host_(host),
      log_(std::move(log)),
      memory_(std::move(memory)),
      session_(std::move(session)),
      to_(to),
      answer_(std::move(search)),
      rest_(rest.pool),
      shutdown_(host.lifecycle.stop_token(), RequestStop{stop_}) {
  Pool& pool = host_.pool_for((*session_)->step_kind());
  const std::int64_t start = (*session_)->start_for(to);
  const double price = (*session_)->most_work(start, to) + rest.price;
  log_.price(price);
  const grpc::Status admitted = admit(ticket_, log_.account(), Ticket::Kind::call, price);
  host_.lifecycle.enter();
  if (!admitted.ok()) {
    finish(admitted);
  } else {
    if (log_.tell_price()) StartSendInitialMetadata();
    Job::bill(log_.account().share(), (*session_)->work(start, to) + rest.price);
    pool.submit(this);
  }
}

CursorCall::CursorCall(Host& host, CallLog log, SessionLease session, std::int64_t to,
                       Answer answer, MemoryLease memory)
    : CursorCall(
          host, std::move(log), std::move(session), to,
          [answer = std::move(answer)](const Session& at, const Cursor& cursor,
                                       const std::stop_token&) { return answer(at, cursor); },
          Rest(), std::move(memory)) {}

CursorCall::CursorCall(Host& host, CallLog log, SessionLease session, std::int64_t to,
                       const Rest& rest, Search search, MemoryLease memory)
    : CursorCall(
          host, std::move(log), std::move(session), to,
          [&host, search = std::move(search)](const Session& at, const Cursor& cursor,
                                              const std::stop_token& stop) -> Answered {
            const auto answered = stoppable(stop, [&] { return search(at, cursor, stop); });
            // An answer computed during a stop may be incomplete.
            if (!answered || stop.stop_requested()) return stopped(host.lifecycle);
            return *answered;
          },
          rest, std::move(memory)) {}

bool CursorCall::run_slice() noexcept {
  if (!cursor_ && !cancelled_ && !make_cursor()) return false;
  try {
    if (cancelled_) {
      finish(errors::cancelled());
    } else if (cursor_done_ || advance_cursor()) {
      cursor_done_ = true;
      if (Pool* const rest = std::exchange(rest_, nullptr)) {
        log_.worked();
        rest->submit(this);
        return false;
      }
      const Answered answered = answer_(**session_, *cursor_, stop_.get_token());
      finish(cancelled_ ? Answered(errors::cancelled()) : answered);
    } else {
      log_.worked();
      return true;
    }
  } catch (...) {
    finish(status_of_exception(host_.lifecycle));
  }
  return false;
}

bool CursorCall::make_cursor() noexcept {
  std::optional<grpc::Status> failure;
  if (!departure_.make([&] { cursor_.emplace(**session_, to_, stop_.get_token()); },
                       [&] { failure = status_of_exception(host_.lifecycle); })) {
    cursor_.reset();
    session_.reset();
    ticket_.give_back();
    if (departure_.is_last()) remove();
    return false;
  }
  if (failure) finish(*failure);
  return !failure;
}

bool CursorCall::advance_cursor() {
  failpoint("call.advance");
  std::int64_t budget = slice_steps((*session_)->step_cost());
  if (!host_.lifecycle.stopping()) return cursor_->advance(to_, budget, stop_.get_token());
  if (cursor_->step() < to_) cursor_->cancel();
  return true;
}

void CursorCall::finish(const Answered& answered) {
  const std::int64_t steps = cursor_ ? cursor_->computed_steps() : 0;
  cursor_.reset();
  session_.reset();
  ticket_.give_back();
  log_.worked();
  when_written(answered, [this, steps](const grpc::Status& status) {
    log_.finish(status, steps);
    Finish(status);
  });
}

void CursorCall::OnCancel() {
  cancelled_ = true;
  stop_.request_stop();
  if (!departure_.answer_now()) return host_.scheduler.hasten(this);
  log_.finish(errors::cancelled());
  Finish(errors::cancelled());
}

void CursorCall::OnDone() {
  if (departure_.is_last()) remove();
}

void CursorCall::remove() {
  Host& host = host_;
  delete this;
  host.lifecycle.leave();
}

PooledCall::PooledCall(Host& host, Pool& pool, CallLog log, Work work, MemoryLease memory,
                       double price)
    : host_(host),
      log_(std::move(log)),
      memory_(std::move(memory)),
      work_(std::move(work)),
      shutdown_(host.lifecycle.stop_token(), RequestStop{stop_}) {
  price = std::max(price, pool.price_cap());
  log_.price(price);
  const grpc::Status admitted = admit(ticket_, log_.account(), Ticket::Kind::call, price);
  host_.lifecycle.enter();
  if (!admitted.ok()) {
    log_.finish(admitted);
    Finish(admitted);
  } else {
    if (log_.tell_price()) StartSendInitialMetadata();
    Job::bill(log_.account().share(), price);
    pool.submit(this);
  }
}

bool PooledCall::run_slice() noexcept {
  Answered answered{grpc::Status::OK};
  try {
    const std::stop_token stop = stop_.get_token();
    answered = cancelled_ ? errors::cancelled() : stoppable(stop, [&] {
                                                    return work_(stop);
                                                  }).value_or(stopped(host_.lifecycle));
  } catch (...) {
    answered = errors::from_current_exception();
  }
  finish(answered);
  return false;
}

void PooledCall::finish(const Answered& answered) {
  ticket_.give_back();
  log_.worked();
  when_written(answered, [this](const grpc::Status& status) {
    log_.finish(status);
    Finish(status);
  });
}

void PooledCall::OnCancel() {
  cancelled_ = true;
  stop_.request_stop();
  host_.scheduler.hasten(this);
}

void PooledCall::OnDone() {
  Host& host = host_;
  delete this;
  host.lifecycle.leave();
}

}  // namespace stiefel::server
