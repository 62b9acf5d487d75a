#include "server/scheduling/helpers.h"

#include <pthread.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>

namespace stiefel::server {
namespace {

/// The time for which items are handed out together, in nanoseconds.
constexpr double portion_nanoseconds = 2e4;
/// By how much the nice value of helpers is above that of other threads.
constexpr int nice_of_helpers = 5;

double clock_nanoseconds() {
  return std::chrono::duration<double, std::nano>(Turns::Clock::now().time_since_epoch()).count();
}

}  // namespace

Helpers::Helpers(Turns& turns, int threads) : turns_(turns) {
  for (int i = 0; i < threads; ++i)
    threads_.emplace_back([this](const std::stop_token& stop) { work(stop); });
}

Helpers::~Helpers() {
  {
    const std::lock_guard lock(mutex_);
    for (std::jthread& thread : threads_) thread.request_stop();
  }
  wake_.notify_all();
}

void Helpers::work(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "help");
  setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + nice_of_helpers);  // of this thread
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    OfCall* leader = next();
    if (!leader || !turns_.take_idle()) {
      wake_.wait(lock);
      continue;
    }
    ++leader->helping_;
    lock.unlock();
    const bool no_work =
        leader->team_.help([this] { return turns_.waiting() > 0; }, &clock_nanoseconds);
    turns_.give_idle();
    lock.lock();
    --leader->helping_;
    if (no_work) leader->wanted_ = std::min<std::size_t>(leader->wanted_, leader->helping_);
    left_.notify_all();
  }
}

void Helpers::call(OfCall& leader, std::size_t wanted) {
  const std::lock_guard lock(mutex_);
  leader.wanted_ = wanted;
  if (!std::exchange(leader.listed_, true)) leaders_.push_back(&leader);
  for (std::size_t k = leader.helping_; k < std::min(wanted, threads_.size()); ++k)
    wake_.notify_one();
}

void Helpers::forget(OfCall& leader) {
  std::unique_lock lock(mutex_);
  leader.wanted_ = 0;
  std::erase(leaders_, &leader);
  left_.wait(lock, [&] { return leader.helping_ == 0; });
}

Helpers::OfCall* Helpers::next() const {
  OfCall* next = nullptr;
  for (OfCall* leader : leaders_)
    if (leader->helping_ < leader->wanted_ && (!next || leader->helping_ < next->helping_))
      next = leader;
  return next;
}

std::size_t Helpers::OfCall::threads_at_hand() {
  const auto idle = static_cast<std::size_t>(helpers_.turns_.idle());
  return 1 + helping_ + std::min(idle, helpers_.threads_.size() - helping_);
}

void Helpers::OfCall::run(std::size_t count, double nanoseconds, Item item, void* context) {
  const double each = nanoseconds / static_cast<double>(count);
  const auto portion = static_cast<std::size_t>(
      std::clamp(portion_nanoseconds / std::max(each, 1.0), 1.0, static_cast<double>(count)));
  const std::size_t wanted = (count + portion - 1) / portion - 1;
  if (wanted > helping_ && threads_at_hand() > 1 + helping_) helpers_.call(*this, wanted);
  const auto bill = [&] {
    turn_.add(std::chrono::duration_cast<Turns::Time>(
        std::chrono::duration<double, std::nano>(team_.take_helpers_work())));
  };
  try {
    team_.run(count, portion, item, context);
  } catch (...) {
    bill();
    throw;
  }
  bill();
}

}  // namespace stiefel::server
