#include "server/scheduling/turns.h"

#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>
#include <tuple>
#include <utility>

namespace stiefel::server {

void Turns::take(OfCall& call, std::unique_lock<std::mutex>& lock) {
  // A principal whose calls have not waited has no credit for that time.
  if (call.share_.waiting_++ == 0) call.share_.used_ = std::max(call.share_.used_, served_);
  const auto place = call.place_.begin();
  queue_.splice(queue_.end(), call.place_);
  ++waiting_;
  call.granted_ = false;
  grant();
  while (!call.granted_) {
    if (call.stop_.stop_requested()) {
      leave(place);
      return;
    }
    if (call.granted_now_.wait_for(lock, waiting_patience) == std::cv_status::no_timeout) continue;
    lock.unlock();
    call.look_for_caller(now_());
    lock.lock();
  }
  call.holds_ = true;
}

void Turns::take_back(OfCall& call, Clock::time_point now) {
  const Time used = now - call.began_ + std::exchange(call.helped_, Time{});
  call.spent_ += used;
  call.share_.used_ += used;
  computed_ += used.count();
  if (std::exchange(call.holds_, false)) ++free_;
}

void Turns::leave(Queue::iterator place) {
  OfCall& call = **place;
  call.place_.splice(call.place_.end(), queue_, place);
  --call.share_.waiting_;
  --waiting_;
}

bool Turns::take_idle() {
  const std::lock_guard lock(mutex_);
  if (free_ <= 0 || !queue_.empty()) return false;
  --free_;
  return true;
}

void Turns::give_idle() {
  const std::lock_guard lock(mutex_);
  ++free_;
  grant();
}

void Turns::grant() {
  for (auto place = next(); place != queue_.end(); place = next()) {
    OfCall& call = **place;
    leave(place);
    --free_;
    served_ = std::max(served_, call.share_.used_);
    call.granted_ = true;
    call.granted_now_.notify_one();
  }
}

Turns::Queue::iterator Turns::next() {
  using Length = OfCall::Length;
  if (free_ < 0 || queue_.empty()) return queue_.end();
  const auto used = [](const OfCall* call) { return call->share_.used_; };
  const Time least = used(*std::ranges::min_element(queue_, {}, used));
  auto best = queue_.end();
  for (auto at = queue_.begin(); at != queue_.end(); ++at) {
    const Length length = (*at)->length();
    if (used(*at) > least + lead || (free_ == 0 && length == Length::long_call)) continue;
    if (best == queue_.end() ||
        std::tuple(length, used(*at)) < std::tuple((*best)->length(), used(*best)))
      best = at;
  }
  return best;
}

void Turns::OfCall::look_for_caller(Clock::time_point now) {
  look_for_caller_at_ = now + patience;
  if (!stop_.stop_requested() && left_()) stop_.request_stop();
}

void Turns::OfCall::pass_at(Clock::time_point now) {
  if (stop_.stop_requested()) return;
  if (now >= look_for_caller_at_) look_for_caller(now);
  const Time over = spent_ + helped_ + (now - began_) - most_;
  time_is_up_ = over > Time{};
  if (over > last_piece) {
    stop_.request_stop();
    return;
  }
  std::unique_lock lock(turns_.mutex_);
  const bool shorter_waits = std::ranges::any_of(
      turns_.queue_, [this](const OfCall* other) { return other->length() < length(); });
  if (holds_ && (turns_.queue_.empty() || (now - began_ < turn && !shorter_waits))) {
    const bool others_wait = !turns_.queue_.empty();
    lock.unlock();
    if (yields_ && others_wait) sched_yield();
    look_at_ = now + look;
    return;
  }
  turns_.take_back(*this, now);
  turns_.take(*this, lock);
  lock.unlock();
  if (!yields_ && length() == Length::long_call) yield_to_others(true);
  began_ = turns_.now_();
  look_at_ = began_ + look;
}

void Turns::OfCall::give() {
  if (yields_) yield_to_others(false);
  const auto now = turns_.now_();
  const std::lock_guard lock(turns_.mutex_);
  const bool held = holds_;
  turns_.take_back(*this, now);
  if (held) turns_.grant();
  began_ = look_at_ = now;
}

/// A thread that yields has SCHED_BATCH and, since Linux 6.12, a time slice so long that a thread
/// that wakes preempts it. Both can be taken back without privileges, unlike a nice value.
void Turns::OfCall::yield_to_others(bool yields) noexcept {
  struct {
    std::uint32_t size, policy;
    std::uint64_t flags;
    std::int32_t nice;
    std::uint32_t priority;
    std::uint64_t runtime, deadline, period;
  } attributes{};
  constexpr std::uint64_t time_slice = 20'000'000;  // ns
  attributes.size = sizeof attributes;
  attributes.policy = yields ? SCHED_BATCH : SCHED_OTHER;
  attributes.nice = getpriority(PRIO_PROCESS, 0);
  attributes.runtime = yields ? time_slice : 0;
  syscall(SYS_sched_setattr, 0, &attributes, 0);  // what the system refuses is left out
  yields_ = yields;
}

void Turns::OfCall::begin() {
  spent_ = {};
  time_is_up_ = false;
  began_ = turns_.now_();
  look_at_ = began_ + free_time;
}

}  // namespace stiefel::server
