#include "server/sessions/pool.h"

#include <pthread.h>

#include <algorithm>

namespace stiefel::server {

std::int64_t slice_steps(double step_cost) {
  return static_cast<std::int64_t>(std::max(1.0, slice_nanoseconds / std::max(step_cost, 1.0)));
}

Pool::Pool(int threads) {
  if (threads <= 0) threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  workers_.reserve(static_cast<std::size_t>(threads));
  for (int i = 0; i < threads; ++i) workers_.emplace_back([this] { work(); });
}

Pool::~Pool() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  workers_.clear();
}

void Pool::submit(Job* job) noexcept {
  bool sleeper;
  {
    const std::lock_guard lock(mutex_);
    push(job);
    sleeper = idle_ > 0;
  }
  if (sleeper) wake_.notify_one();
}

void Pool::push(Job* job) {
  job->next_ = nullptr;
  (first_ ? last_->next_ : first_) = job;
  last_ = job;
}

Job* Pool::pop() {
  Job* job = first_;
  first_ = job->next_;
  return job;
}

void Pool::work() {
  pthread_setname_np(pthread_self(), thread_name);
  std::unique_lock lock(mutex_);
  while (true) {
    ++idle_;
    wake_.wait(lock, [this] { return stopping_ || first_; });
    --idle_;
    if (!first_) return;
    Job* job = pop();
    lock.unlock();
    const bool more = job->run_slice();
    lock.lock();
    if (more) push(job);
  }
}

}  // namespace stiefel::server
