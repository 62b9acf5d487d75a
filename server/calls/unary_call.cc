#include "server/calls/unary_call.h"

#include <algorithm>
#include <utility>

namespace stiefel::server {
namespace {

grpc::Status status_of(const WriteFault& fault) noexcept {
  try {
    return errors::not_written(fault);
  } catch (...) {
    return errors::out_of_memory();
  }
}

/// Calls `send` once with the status, or with the store's error: at once if nothing is being
/// written, else on the store's thread. Blocks no thread. `send` must not throw.
void when_written(const Answered& answered, const std::function<void(const grpc::Status&)>& send) {
  if (!answered.pending_write) return send(answered.status);
  try {
    answered.pending_write->then([send, status = answered.status](const auto& fault) {
      fault ? send(status_of(*fault)) : send(status);
    });
  } catch (...) {
    send(errors::from_current_exception());
  }
}

}  // namespace

UnaryCall::UnaryCall(Host& host, CallLog log, SessionLease session, std::int64_t to,
                     const MoreWork& more, Answer answer, MemoryLease memory)
    : Call(host, std::move(log), std::move(memory)),
      session_(std::move(session)),
      to_(to),
      answer_([this, copies = more.price == 0, answer = std::move(answer)]() -> Answered {
        if (copies) return answer(**session_, *cursor_, stop());
        const auto answered =
            stoppable(stop(), [&] { return answer(**session_, *cursor_, stop()); });
        // An answer computed during a stop may be incomplete.
        return answered && !stop().stop_requested() ? *answered : errors::cancelled();
      }),
      more_(more.kind),
      steps_done_(false) {
  const std::int64_t start = (*session_)->start_for(to);
  begin((*session_)->step_kind().kind, Permit::Kind::call,
        (*session_)->most_work(start, to) + more.price, (*session_)->work(start, to) + more.price);
}

UnaryCall::UnaryCall(Host& host, CallLog log, JobKind kind, double price, Work work,
                     MemoryLease memory)
    : Call(host, std::move(log), std::move(memory)),
      answer_([this, work = std::move(work)]() -> Answered {
        return stoppable(stop(), [&] { return work(stop()); }).value_or(errors::cancelled());
      }) {
  price = std::max(price, price_cap(kind));
  begin(kind, Permit::Kind::call, price, price, true);
}

UnaryCall::UnaryCall(Host& host, CallLog log, const Answered& answered, MemoryLease memory)
    : Call(host, std::move(log), std::move(memory)) {
  run();
  finish(answered);
}

grpc::Status UnaryCall::make() {
  cursor_.emplace(**session_, to_, stop());
  return grpc::Status::OK;
}

bool UnaryCall::run_slice() noexcept {
  if (session_ && !cursor_ && !cancelled() && !make_now()) return false;
  try {
    if (cancelled()) {
      end(errors::cancelled());
      return false;
    }
    if (!steps_done_) {
      std::int64_t budget = slice_steps((*session_)->step_cost());
      if (host_.lifecycle.stopping()) {
        if (cursor_->step() < to_) cursor_->cancel();
      } else if (!cursor_->advance(to_, budget, stop())) {
        log_.worked();
        return true;
      }
      steps_done_ = true;
      if (!cancelled() && cursor_->stopped()) {
        end(errors::shutting_down(**session_, cursor_->simulation()));
        return false;
      }
    }
    if (const auto kind = std::exchange(more_, std::nullopt)) {
      log_.worked();
      host_.scheduler.submit(this, *kind);
      return false;
    }
    const Answered answered = answer_();
    finish(cancelled() ? Answered(errors::cancelled()) : answered);
  } catch (...) {
    end(errors::from_current_exception());
  }
  return false;
}

void UnaryCall::free() noexcept {
  steps_ = computed_steps();
  cursor_.reset();
  session_.reset();
}

void UnaryCall::finish(const Answered& answered) {
  log_.worked();
  if (answered.pending_write) release();
  when_written(answered, [this](const grpc::Status& status) { end(status); });
}

}  // namespace stiefel::server
