#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "engine/simulation/run/crew.h"
#include "server/scheduling/run_queue.h"

namespace stiefel::server {

/// Returns the work of the slice that this thread runs, and of the threads that helped it, in
/// instructions: since the slice began or since the last call. 0 outside a slice.
double take_slice_work();

/// The threads that compute, shared by stepping, ensembles and searches. Jobs run one slice at a
/// time in the order of RunQueue. With two threads or more, one worker is kept for short jobs: of
/// the longer ones it runs only those with brief slices, and those with ordinary slices while all
/// other workers are inside unsliced jobs. With one thread, a second worker runs short jobs while
/// the first is inside an unsliced job. Workers with nothing to do help a job that advances an
/// ensemble. The threads have a lower priority than those of gRPC.
class Scheduler final : private Crew {
 public:
  /// Returns the work that the calling thread has done so far, in instructions.
  using Meter = std::function<double()>;
  /// The name of the threads in ps and top.
  static constexpr const char* thread_name = "compute";

  /// 0 threads means one a core. An empty meter means the thread's processor time at a nominal
  /// rate.
  explicit Scheduler(int threads, Meter meter = {});
  /// Runs all queued jobs to their end.
  ~Scheduler() override;
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  /// Queues a job, which must live until its `run_slice` returns false. Allocates nothing, so that
  /// a submitted job runs whatever memory is left.
  void submit(Job* job, JobKind kind) noexcept;
  /// Lets a job whose caller has left wait no more. If the job is queued, runs its slices on this
  /// thread until one returns false; the job may then be destroyed. If a worker runs a slice of it,
  /// that worker goes on with its next slice at once. If it rests, `submit` runs it. Call this only
  /// when each slice that begins afterwards returns at once.
  void hasten(Job* job) noexcept;
  /// Stops limiting jobs by the work rates of their principals, so that all jobs end.
  void lift_rates();
  int threads() const { return threads_; }
  /// The work of all slices that have ended, in instructions.
  double work_done() const { return work_done_.load(std::memory_order_relaxed); }
  /// RunQueue::waiting_work. Thread-safe.
  std::uint64_t waiting_work() const { return queue_.waiting_work(); }

 private:
  struct Items;
  class Helper;
  static constexpr std::size_t most_helpers = 63;

  void work(bool kept);
  /// Returns the longest kind of slices that the worker runs beside short jobs; nothing if it runs
  /// short jobs only.
  std::optional<JobKind> reach(bool kept) const;
  /// Whether the kept worker runs jobs now.
  bool kept_runs() const { return threads_ > 1 || in_unsliced_ > 0; }
  void wait(std::unique_lock<std::mutex>& lock, bool kept);
  /// Wakes an idle worker that may run a new job of this kind, if there is one.
  void wake_for(JobKind kind, bool is_short);
  /// Wakes an idle worker while jobs wait: the worker that took a job may have been woken for two.
  void wake_another();
  void run(std::size_t count, double nanoseconds, Item item, void* context) override;
  std::size_t call_helpers(std::array<Helper, most_helpers>& helpers, Items& items, JobKind kind);
  void dismiss(std::span<Helper> helpers);
  /// Runs the slices of a hastened job, without the lock.
  static void finish(Job* job) noexcept;

  const Meter meter_;
  const int threads_;
  std::mutex mutex_;
  std::condition_variable wake_, wake_kept_, helped_;
  RunQueue queue_;        // guarded by mutex_, as are the members below
  std::size_t idle_ = 0;  // workers with nothing to do, without the kept one
  bool kept_idle_ = false;
  std::size_t in_unsliced_ = 0;  // workers inside unsliced jobs
  const std::size_t others_;     // workers that are not kept
  std::atomic<double> work_done_ = 0;
  bool stopping_ = false;
  std::vector<std::jthread> workers_;
};

}  // namespace stiefel::server
