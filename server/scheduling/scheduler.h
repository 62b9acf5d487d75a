#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "server/scheduling/run_queue.h"
#include "stiefel/crew.h"

namespace stiefel::server {

/// Returns the work of the slice that this thread runs, and of the threads that helped it, in
/// instructions: since the slice began or since the last call. 0 outside a slice.
double take_slice_work();

/// The threads that compute, shared by stepping, ensembles and searches. Jobs run one slice at a
/// time in the order of RunQueue. The threads have a lower priority than those of gRPC. A worker
/// with nothing to do helps a job that divides its work, such as the members of an ensemble, and
/// leaves it between two items as soon as a job is submitted. What helpers do counts as work of the
/// job. In place of the kept worker, which must be there for short jobs, an extra worker helps with
/// items that are too long for it, beginning while it is idle.
///
/// One worker is kept for short jobs. With two threads or more it also runs longer jobs with brief
/// slices and, while all other workers are inside unsliced jobs, those with ordinary slices. With
/// one thread it is an additional worker, which runs short jobs while the other is inside an
/// unsliced job.
///
/// A search of one principal does not hold up the others. When every worker but the kept one has
/// been inside one slice for `extra_patience`, each principal with a waiting longer job that has
/// no search running gets an extra worker: one more thread, at most `most_extra` in all, among
/// which the system divides the processors.
class Scheduler final : private Crew {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// Returns the work that the calling thread has done so far, in instructions.
  using Meter = std::function<double()>;
  /// The name of the threads in ps and top.
  static constexpr const char* thread_name = "compute";
  static constexpr std::chrono::milliseconds extra_patience{50};
  static constexpr std::size_t most_extra = 16;

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
  void cancel(Job* job) noexcept;
  int threads() const { return threads_; }
  /// The work of all slices that have ended, in instructions.
  double work_done() const { return work_done_.load(std::memory_order_relaxed); }
  /// RunQueue::waiting_work. Thread-safe.
  std::uint64_t waiting_work() const { return queue_.waiting_work(); }
  /// Whether a long job waits. Thread-safe.
  bool long_waits() const { return queue_.long_waits(); }

 private:
  /// A worker that has divided its work.
  struct Leader {
    Team team;
    std::atomic<std::size_t> helpers = 0;
    std::atomic<double> nanoseconds = 0;  // of a portion of the items
    std::size_t wanted = 0;               // helpers; guarded by mutex_
  };

  /// The workers that help: one that is not kept, the kept one, an extra one in its place.
  enum class Helper : std::uint8_t { other, kept, stand_in };

  /// The loop of a worker; `index` is its place in leaders_ and, unless it is kept, in since_.
  void work(bool kept, std::size_t index);
  /// Runs a slice of the job, without the lock; returns whether the job is queued again.
  bool run_slice(const RunQueue::Turn& turn, double nanoseconds,
                 std::unique_lock<std::mutex>& lock);
  /// The loop of an extra worker.
  void work_beside(std::size_t index);
  /// Starts one more extra worker, unless there are enough or the system refuses a thread.
  void add_extra() noexcept;
  /// Wakes an extra worker that may have something to do soon.
  void wake_extra();
  /// Returns the time from which extra workers may take jobs; nothing while a worker that is not
  /// kept may take one.
  std::optional<Time> extra_due() const;
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
  std::size_t threads_at_hand() override;
  void run(std::size_t count, double nanoseconds, Item item, void* context) override;
  /// Wakes idle workers, so that the leader has up to `wanted` helpers.
  void call_helpers(Leader& leader, std::size_t wanted);
  /// Returns the leader with the fewest helpers of those that the worker may help.
  Leader* next_leader(Helper helper);
  /// Helps the leader, without the lock, until a job is submitted or it divides no more work.
  void help(Leader& leader, Helper helper, std::size_t index, std::unique_lock<std::mutex>& lock);
  /// Lets an extra worker help in place of the kept one, if it may and a leader wants it.
  void wake_stand_in();
  /// Counts the worker as inside an unsliced job, or no longer.
  void enter_unsliced(std::size_t index);
  void leave_unsliced(std::size_t index);
  /// Lets helpers look for jobs.
  void recall_helpers() { submissions_.fetch_add(1, std::memory_order_relaxed); }
  /// Runs the slices of a cancelled job, without the lock.
  static void finish(Job* job) noexcept;

  static thread_local Leader* leader_here;  // of this worker

  const Meter meter_;
  const int threads_;
  std::mutex mutex_;
  std::condition_variable wake_, wake_kept_, wake_extra_;
  RunQueue queue_;                     // guarded by mutex_, as are the members below
  std::atomic<std::size_t> idle_ = 0;  // workers with nothing to do, without the kept one
  std::atomic<bool> kept_idle_ = false;
  std::atomic<bool> stands_in_ = false;         // an extra worker helps in place of the kept one
  std::atomic<std::uint64_t> submissions_ = 0;  // and other events for which helpers look for jobs
  std::size_t in_unsliced_ = 0;                 // workers inside unsliced jobs
  const std::size_t others_;                    // workers that are not kept
  /// When each of these began the unsliced slice that it is inside; `outside` if it is not in one.
  std::vector<Time> since_;
  static constexpr Time outside = Time::max();
  std::size_t extra_idle_ = 0;
  std::atomic<double> work_done_ = 0;
  bool stopping_ = false;
  std::vector<Leader> leaders_;  // one for each worker
  std::vector<std::jthread> workers_, extra_;
};

}  // namespace stiefel::server
