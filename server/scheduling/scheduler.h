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

/// The work of the slice that this thread runs, and of those that helped it, in instructions: since
/// the slice began, or since the last call. 0 outside a slice.
double take_slice_work();

/// The threads that compute: one budget for stepping, ensembles and searches. Jobs run one slice at
/// a time in the order of RunQueue. With two threads or more one worker is kept for short jobs: of
/// longer ones it runs brief slices only, sliced ones while every other worker is inside a whole
/// one, and never a whole one. With one thread a second worker runs short jobs alone, while the
/// first is inside a whole slice. An ensemble that a job advances is shared with the workers that
/// have nothing to do. The threads have a lower priority than those of gRPC.
class Scheduler final : private Crew {
 public:
  /// The work that the calling thread has done so far, in instructions.
  using Meter = std::function<double()>;
  /// What ps and top call the threads.
  static constexpr const char* thread_name = "compute";

  /// 0 threads means one a core. Without a meter: the thread's processor time at a nominal rate.
  explicit Scheduler(int threads, Meter meter = {});
  /// Runs what is queued to its end.
  ~Scheduler() override;
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  /// The job must live until its `run_slice` returns false. Allocates nothing: a job that is
  /// submitted runs, whatever memory is left.
  void submit(Job* job, JobKind kind) noexcept;
  /// From now on no job waits for its principal's work rate: what runs is to end.
  void lift_rates();
  int threads() const { return threads_; }
  /// The work of all slices that have ended, in instructions.
  double work_done() const { return work_done_.load(std::memory_order_relaxed); }
  /// RunQueue::waiting_work.
  std::uint64_t waiting_work() const { return queue_.waiting_work(); }

 private:
  struct Items;
  class Helper;
  static constexpr std::size_t most_helpers = 63;

  void work(bool kept);
  /// The longest slices that the worker runs beside short jobs; none if it runs no others.
  std::optional<JobKind> reach(bool kept) const;
  /// Whether the kept worker runs jobs now.
  bool kept_runs() const { return threads_ > 1 || in_whole_ > 0; }
  void wait(std::unique_lock<std::mutex>& lock, bool kept);
  /// Wakes a worker that may run it, if one has nothing to do.
  void wake_for(JobKind kind, bool is_short);
  /// Wakes a worker with nothing to do while jobs wait: one call may have woken it for two jobs.
  void wake_another();
  void run(std::size_t count, double nanoseconds, Item item, void* context) override;
  std::size_t call_helpers(std::array<Helper, most_helpers>& helpers, Items& items, JobKind kind);
  void dismiss(std::span<Helper> helpers);

  const Meter meter_;
  const int threads_;
  std::mutex mutex_;
  std::condition_variable wake_, wake_kept_, helped_;
  RunQueue queue_;        // guarded by mutex_, as the rest is
  std::size_t idle_ = 0;  // workers with nothing to do, but for the kept one
  bool kept_idle_ = false;
  std::size_t in_whole_ = 0;  // workers inside a whole slice
  const std::size_t others_;  // workers that are not kept
  std::atomic<double> work_done_ = 0;
  bool stopping_ = false;
  std::vector<std::jthread> workers_;
};

}  // namespace stiefel::server
