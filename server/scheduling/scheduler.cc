#include "server/scheduling/scheduler.h"

#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <utility>

#include "server/scheduling/failpoint.h"
#include "server/scheduling/slice.h"

namespace stiefel::server {
namespace {

/// The time for which items of an ensemble are handed out together.
constexpr double portion_nanoseconds = 2e4;

double processor_work() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return instructions_a_nanosecond *
         (1e9 * static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec));
}

/// Lowers the calling thread's priority below that of the threads that serve connections, which
/// have the process's nice value: by 1 for the worker kept for short calls (`kept`), by 5 for the
/// others. The others also get SCHED_BATCH, with which a thread that wakes does not preempt a
/// running one. Ignores what the system refuses.
void lower_priority(bool kept) noexcept {
  constexpr int kept_below = 1, others_below = 5;
  if (!kept) {
    const sched_param none{};
    sched_setscheduler(0, SCHED_BATCH, &none);
  }
  // On Linux, 0 means the calling thread, and each thread has its own nice value.
  setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + (kept ? kept_below : others_below));
}

/// The share of the job that this worker runs.
thread_local Share* share_at_work = nullptr;
/// The meter of the slice that this thread runs, null outside a slice, and its reading when the
/// work was last taken.
thread_local const Scheduler::Meter* slice_meter = nullptr;
thread_local double slice_mark = 0;

}  // namespace

double take_slice_work() {
  if (!slice_meter) return 0;
  const double before = std::exchange(slice_mark, (*slice_meter)());
  return slice_mark - before;
}

/// Items of an ensemble that several workers do together.
struct Scheduler::Items {
  const std::size_t count, portion;
  const Item item;
  void* const context;
  std::atomic<std::size_t> next = 0;
  std::exception_ptr failure = nullptr;  // guarded by the scheduler's mutex, as is helpers_work
  double helpers_work = 0;               // instructions

  /// Does items until none is left or `pause` returns true.
  template <class Pause>
  void run(const Pause& pause) {
    while (!pause()) {
      const std::size_t first = next.fetch_add(portion, std::memory_order_relaxed);
      if (first >= count) return;
      failpoint("scheduler.items");
      for (std::size_t i = first; i < std::min(first + portion, count); ++i) item(context, i);
    }
  }
};

/// Lets one more worker do items, until a short job waits.
class Scheduler::Helper final : public Job {
 public:
  void join(Scheduler& scheduler, Items& items, Share& share) {
    scheduler_ = &scheduler;
    items_ = &items;
    bill(share, no_price);
  }
  bool done() const { return done_; }

 private:
  bool run_slice() noexcept override {
    Scheduler& scheduler = *scheduler_;
    std::exception_ptr failure;
    try {
      items_->run([&] { return scheduler.queue_.short_waits(); });
    } catch (...) {
      failure = std::current_exception();
    }
    const std::lock_guard lock(scheduler.mutex_);
    if (failure) items_->failure = failure;
    items_->helpers_work += take_slice_work();
    done_ = true;
    scheduler.helped_.notify_all();
    return false;
  }

  Scheduler* scheduler_ = nullptr;
  Items* items_ = nullptr;
  bool done_ = false;  // guarded by the scheduler's mutex
};

Scheduler::Scheduler(int threads, Meter meter)
    : meter_(meter ? std::move(meter) : Meter(&processor_work)),
      threads_(threads > 0 ? threads
                           : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()))),
      others_(static_cast<std::size_t>(std::max(1, threads_ - 1))),
      since_(others_, outside) {
  workers_.reserve(others_ + 1);
  extra_.reserve(most_extra);
  for (std::size_t i = 0; i < others_; ++i) workers_.emplace_back([this, i] { work(false, i); });
  workers_.emplace_back([this] { work(true, others_); });
  const std::lock_guard lock(mutex_);
  add_extra();
}

Scheduler::~Scheduler() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  wake_kept_.notify_all();
  wake_extra_.notify_all();
  extra_.clear();
  workers_.clear();
}

void Scheduler::submit(Job* job, JobKind kind) noexcept {
  {
    const std::lock_guard lock(mutex_);
    if (!job->cancelled_) {
      const bool is_long = queue_.push(job, kind) == JobLength::long_job;
      wake_for(kind, !is_long);
      if (is_long) wake_extra();
      return;
    }
  }
  finish(job);
}

void Scheduler::cancel(Job* job) noexcept {
  {
    const std::lock_guard lock(mutex_);
    job->cancelled_ = true;
    if (!RunQueue::is_queued(job)) return;
    queue_.remove(job);
  }
  finish(job);
}

void Scheduler::finish(Job* job) noexcept {
  while (job->run_slice()) {
  }
}

void Scheduler::wake_for(JobKind kind, bool is_short) {
  if (kept_idle_ && is_short && kept_runs())
    wake_kept_.notify_one();
  else if (idle_ > 0)
    wake_.notify_one();
  else if (kept_idle_ && kind <= reach(true))
    wake_kept_.notify_one();
}

void Scheduler::wake_another() {
  if (queue_.empty()) return;
  if (idle_ > 0)
    wake_.notify_one();
  else if (kept_idle_ && kept_runs())
    wake_kept_.notify_one();
}

std::optional<JobKind> Scheduler::reach(bool kept) const {
  if (!kept) return JobKind::unsliced;
  if (threads_ == 1) return std::nullopt;
  return in_unsliced_ == others_ ? JobKind::sliced : JobKind::brief;
}

void Scheduler::wait(std::unique_lock<std::mutex>& lock, bool kept) {
  std::condition_variable& wake = kept ? wake_kept_ : wake_;
  kept ? void(kept_idle_ = true) : void(++idle_);
  wake.wait(lock);
  kept ? void(kept_idle_ = false) : void(--idle_);
}

void Scheduler::work(bool kept, std::size_t index) {
  pthread_setname_np(pthread_self(), thread_name);
  lower_priority(kept);
  const CrewOfThisThread crew(*this);
  std::unique_lock lock(mutex_);
  while (true) {
    const RunQueue::Turn turn = kept && !kept_runs() ? RunQueue::Turn() : queue_.pop(reach(kept));
    if (!turn.job && stopping_) return;
    if (!turn.job) {
      wait(lock, kept);
      continue;
    }
    const bool unsliced = turn.kind == JobKind::unsliced;
    if (unsliced) {
      ++in_unsliced_;
      since_[index] = std::chrono::steady_clock::now();
      wake_extra();
    }
    wake_another();
    const bool more = run_slice(
        turn,
        kept && turn.length != JobLength::short_job ? brief_slice_nanoseconds : slice_nanoseconds,
        lock);
    if (unsliced) {
      --in_unsliced_;
      since_[index] = outside;
    }
    // The job may have become too long for the kept worker.
    if (kept && more) {
      wake_another();
      wake_extra();
    }
  }
}

std::optional<Scheduler::Time> Scheduler::extra_due() const {
  const Time last = *std::ranges::max_element(since_);
  if (last == outside) return std::nullopt;
  return last + extra_patience;
}

void Scheduler::wake_extra() {
  if (extra_idle_ > 0 && in_unsliced_ == others_ && !queue_.empty()) wake_extra_.notify_one();
}

void Scheduler::add_extra() noexcept {
  if (extra_.size() == most_extra || stopping_) return;
  try {
    extra_.emplace_back([this] { work_beside(); });
  } catch (const std::exception&) {  // the jobs wait for the other workers
  }
}

/// One extra worker is always idle, so that the next principal finds one.
void Scheduler::work_beside() {
  pthread_setname_np(pthread_self(), thread_name);
  lower_priority(false);
  const CrewOfThisThread crew(*this);
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const Time now = std::chrono::steady_clock::now();
    std::optional<Time> next = extra_due();
    if (next && *next <= now) {
      if (const RunQueue::Turn turn = queue_.pop_neglected(); turn.job) {
        extra_idle_ > 0 ? wake_extra_.notify_one() : add_extra();
        run_slice(turn, slice_nanoseconds, lock);
        continue;
      }
      next.reset();
    }
    ++extra_idle_;
    if (next && !queue_.empty())
      wake_extra_.wait_until(lock, *next);
    else
      wake_extra_.wait(lock);
    --extra_idle_;
  }
}

bool Scheduler::run_slice(const RunQueue::Turn& turn, double nanoseconds,
                          std::unique_lock<std::mutex>& lock) {
  lock.unlock();
  share_at_work = turn.share;
  const double before = meter_();
  slice_meter = &meter_;
  slice_mark = before;
  bool more;
  {
    const SliceLength length(nanoseconds);
    more = turn.job->run_slice();
  }
  const double done = meter_() - before;
  slice_meter = nullptr;
  lock.lock();
  work_done_.fetch_add(done, std::memory_order_relaxed);
  const bool last = more && turn.job->cancelled_;
  queue_.charge(turn, done, more && !last);
  if (last) {
    lock.unlock();
    finish(turn.job);
    lock.lock();
  }
  return more && !last;
}

void Scheduler::run(std::size_t count, double nanoseconds, Item item, void* context) {
  const double each = nanoseconds / static_cast<double>(count);
  const double portion = std::clamp(portion_nanoseconds / std::max(each, 1.0), 1.0, 1e9);
  Items items{count, static_cast<std::size_t>(portion), item, context};
  std::array<Helper, most_helpers> helpers;
  const std::size_t called = call_helpers(helpers, items, kind_of_steps(each));
  std::exception_ptr failure;
  try {
    items.run([] { return false; });
  } catch (...) {
    failure = std::current_exception();
  }
  dismiss(std::span(helpers).first(called));
  slice_mark -= items.helpers_work;
  if (!failure) failure = items.failure;
  if (failure) std::rethrow_exception(failure);
}

std::size_t Scheduler::call_helpers(std::array<Helper, most_helpers>& helpers, Items& items,
                                    JobKind kind) {
  const std::lock_guard lock(mutex_);
  const std::size_t free = idle_ + (kept_idle_ && kind <= reach(true));
  const std::size_t portions = (items.count + items.portion - 1) / items.portion;
  const std::size_t called = std::min({free, portions - 1, most_helpers});
  for (Helper& helper : std::span(helpers).first(called)) {
    helper.join(*this, items, *share_at_work);
    queue_.push(&helper, kind);
    (idle_ > 0 ? wake_ : wake_kept_).notify_one();
  }
  if (called > 0 && called > idle_) wake_kept_.notify_one();
  return called;
}

void Scheduler::dismiss(std::span<Helper> helpers) {
  std::unique_lock lock(mutex_);
  for (Helper& helper : helpers) {
    if (RunQueue::is_queued(&helper))
      queue_.remove(&helper);
    else
      helped_.wait(lock, [&] { return helper.done(); });
  }
}

}  // namespace stiefel::server
