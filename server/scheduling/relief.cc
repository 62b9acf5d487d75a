#include <pthread.h>

#include <algorithm>
#include <system_error>

#include "server/scheduling/priority.h"
#include "server/scheduling/scheduler.h"
#include "server/scheduling/slice.h"

namespace stiefel::server {

std::optional<RunQueue::Time> Scheduler::relief_due() const {
  const RunQueue::Time last = *std::ranges::max_element(since_);
  if (last == outside) return std::nullopt;
  return last + relief_patience;
}

void Scheduler::wake_relief() {
  if (relief_idle_ > 0 && in_unsliced_ == others_ && !queue_.empty()) wake_relief_.notify_one();
}

void Scheduler::add_relief() noexcept {
  if (relief_.size() == most_relief || stopping_) return;
  try {
    relief_.emplace_back([this] { relieve(); });
  } catch (const std::exception&) {  // the jobs wait for the other workers
  }
}

/// One relief worker is always idle, so that the next principal finds one.
void Scheduler::relieve() {
  pthread_setname_np(pthread_self(), thread_name);
  lower_priority(false);
  const CrewOfThisThread crew(*this);
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const RunQueue::Time now = std::chrono::steady_clock::now();
    std::optional<RunQueue::Time> next = relief_due();
    if (next && *next <= now) {
      if (const RunQueue::Turn turn = queue_.pop_neglected(now); turn.job) {
        relief_idle_ > 0 ? wake_relief_.notify_one() : add_relief();
        run_slice(turn, slice_nanoseconds, lock);
        continue;
      }
      next = queue_.ready_at();
    }
    ++relief_idle_;
    if (next && !queue_.empty())
      wake_relief_.wait_until(lock, *next);
    else
      wake_relief_.wait(lock);
    --relief_idle_;
  }
}

}  // namespace stiefel::server
