#include "server/scheduling/scheduler.h"

#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <utility>

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

/// The meter of the slice that this thread runs, null outside a slice, and its reading when the
/// work was last taken.
thread_local const Scheduler::Meter* slice_meter = nullptr;
thread_local double slice_mark = 0;
/// The work of helpers in the slice that this thread runs, in instructions.
thread_local double helpers_work = 0;

}  // namespace

thread_local Scheduler::Leader* Scheduler::leader_here = nullptr;

double take_slice_work() {
  if (!slice_meter) return 0;
  const double before = std::exchange(slice_mark, (*slice_meter)());
  return slice_mark - before;
}

Scheduler::Scheduler(int threads, Meter meter)
    : meter_(meter ? std::move(meter) : Meter(&processor_work)),
      threads_(threads > 0 ? threads
                           : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()))),
      others_(static_cast<std::size_t>(std::max(1, threads_ - 1))),
      since_(others_, outside),
      leaders_(others_ + 1 + most_extra) {
  limit_threads(1);  // of the library: these threads are the only ones that compute
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
    recall_helpers();
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
  recall_helpers();
  if (kept_idle_ && is_short && kept_runs())
    wake_kept_.notify_one();
  else if (idle_ > 0)
    wake_.notify_one();
  else if (kept_idle_ && kind <= reach(true))
    wake_kept_.notify_one();
}

void Scheduler::wake_another() {
  if (queue_.empty()) return;
  recall_helpers();
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
  if (kept) wake_stand_in();
  wake.wait(lock);
  kept ? void(kept_idle_ = false) : void(--idle_);
}

void Scheduler::work(bool kept, std::size_t index) {
  pthread_setname_np(pthread_self(), thread_name);
  lower_priority(kept);
  const CrewOfThisThread crew(*this);
  leader_here = &leaders_[index];
  std::unique_lock lock(mutex_);
  while (true) {
    const RunQueue::Turn turn = kept && !kept_runs() ? RunQueue::Turn() : queue_.pop(reach(kept));
    if (!turn.job && stopping_) return;
    if (!turn.job) {
      const Helper helper = kept ? Helper::kept : Helper::other;
      if (Leader* leader = next_leader(helper))
        help(*leader, helper, index, lock);
      else
        wait(lock, kept);
      continue;
    }
    const bool unsliced = turn.kind == JobKind::unsliced;
    if (unsliced) enter_unsliced(index);
    wake_another();
    const bool more = run_slice(
        turn,
        kept && turn.length != JobLength::short_job ? brief_slice_nanoseconds : slice_nanoseconds,
        lock);
    if (unsliced) leave_unsliced(index);
    // The job may have become too long for the kept worker.
    if (kept && more) {
      wake_another();
      wake_extra();
    }
  }
}

void Scheduler::enter_unsliced(std::size_t index) {
  ++in_unsliced_;
  since_[index] = std::chrono::steady_clock::now();
  wake_extra();
}

void Scheduler::leave_unsliced(std::size_t index) {
  --in_unsliced_;
  since_[index] = outside;
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
    extra_.emplace_back([this, index = others_ + 1 + extra_.size()] { work_beside(index); });
  } catch (const std::exception&) {  // the jobs wait for the other workers
  }
}

/// One extra worker is always idle, so that the next principal finds one.
void Scheduler::work_beside(std::size_t index) {
  pthread_setname_np(pthread_self(), thread_name);
  lower_priority(false);
  const CrewOfThisThread crew(*this);
  leader_here = &leaders_[index];
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
    if (Leader* leader = next_leader(Helper::stand_in)) {
      stands_in_ = true;
      if (extra_idle_ == 0) add_extra();
      help(*leader, Helper::stand_in, index, lock);
      stands_in_ = false;
      continue;
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
  helpers_work = 0;
  const double before = meter_();
  slice_meter = &meter_;
  slice_mark = before;
  bool more;
  {
    const SliceLength length(nanoseconds);
    more = turn.job->run_slice();
  }
  const double done = meter_() - before + helpers_work;
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

std::size_t Scheduler::threads_at_hand() {
  const bool kept = threads_ > 1 && kept_idle_.load(std::memory_order_relaxed) &&
                    !stands_in_.load(std::memory_order_relaxed);
  return 1 + leader_here->helpers.load(std::memory_order_relaxed) +
         idle_.load(std::memory_order_relaxed) + kept;
}

void Scheduler::run(std::size_t count, double nanoseconds, Item item, void* context) {
  const double each = nanoseconds / static_cast<double>(count);
  const auto portion = static_cast<std::size_t>(
      std::clamp(portion_nanoseconds / std::max(each, 1.0), 1.0, static_cast<double>(count)));
  const std::size_t portions = (count + portion - 1) / portion;
  Leader& leader = *leader_here;
  const double of_portion = each * static_cast<double>(portion);
  leader.nanoseconds.store(of_portion, std::memory_order_relaxed);
  // Workers that are busy now may be free before long portions end.
  const bool may_have_more =
      threads_at_hand() > 1 + leader.helpers.load(std::memory_order_relaxed) ||
      of_portion > slice_nanoseconds;
  struct Context {
    Scheduler& scheduler;
    Leader& leader;
    std::size_t wanted;  // helpers
    Item item;
    void* context;
  } inner{*this, leader, may_have_more ? portions - 1 : 0, item, context};
  const auto inner_item = [](void* all, std::size_t index) {
    Context& of = *static_cast<Context*>(all);
    // Now helpers find items: one that takes the place of the leader on its core does some of them.
    if (index == 0 && of.wanted > 0) of.scheduler.call_helpers(of.leader, of.wanted);
    of.item(of.context, index);
  };
  const auto take_helpers_work = [&] {
    const double work = leader.team.take_helpers_work();
    helpers_work += work;
    slice_mark -= work;
  };
  try {
    leader.team.run(count, portion, inner_item, &inner);
  } catch (...) {
    take_helpers_work();
    throw;
  }
  take_helpers_work();
}

void Scheduler::call_helpers(Leader& leader, std::size_t wanted) {
  const std::lock_guard lock(mutex_);
  leader.wanted = wanted;
  const std::size_t most = std::min(wanted, leader.helpers + idle_);
  for (std::size_t k = leader.helpers; k < most; ++k) wake_.notify_one();
  if (most < wanted && kept_idle_ && next_leader(Helper::kept))
    wake_kept_.notify_one();
  else if (most < wanted)
    wake_stand_in();
}

void Scheduler::wake_stand_in() {
  if (extra_idle_ > 0 && next_leader(Helper::stand_in)) wake_extra_.notify_one();
}

Scheduler::Leader* Scheduler::next_leader(Helper helper) {
  if (helper == Helper::stand_in && (threads_ == 1 || !kept_idle_ || stands_in_)) return nullptr;
  Leader* next = nullptr;
  const std::optional<JobKind> most = reach(helper != Helper::other);
  for (Leader& leader : leaders_) {
    const bool within = kind_of_steps(leader.nanoseconds) <= most;
    if (leader.helpers < leader.wanted && within == (helper != Helper::stand_in) &&
        (!next || leader.helpers < next->helpers))
      next = &leader;
  }
  return next;
}

void Scheduler::help(Leader& leader, Helper helper, std::size_t index,
                     std::unique_lock<std::mutex>& lock) {
  const bool kept = helper == Helper::kept;
  const std::optional<JobKind> most = reach(kept);
  const bool unsliced =
      helper == Helper::other && kind_of_steps(leader.nanoseconds) == JobKind::unsliced;
  const std::uint64_t seen = submissions_.load(std::memory_order_relaxed);
  ++leader.helpers;
  if (unsliced) enter_unsliced(index);
  lock.unlock();
  const bool no_work = leader.team.help(
      [&] {
        return submissions_.load(std::memory_order_relaxed) != seen ||
               (kept && kind_of_steps(leader.nanoseconds.load(std::memory_order_relaxed)) > most);
      },
      meter_);
  lock.lock();
  if (unsliced) leave_unsliced(index);
  --leader.helpers;
  if (no_work) leader.wanted = std::min<std::size_t>(leader.wanted, leader.helpers);
}

}  // namespace stiefel::server
