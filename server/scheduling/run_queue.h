#pragma once

#include <array>
#include <atomic>
#include <optional>

#include "server/scheduling/job.h"
#include "server/scheduling/work_rate.h"

namespace stiefel::server {

/// Jobs in the order of their arrival. Allocates nothing.
class JobList {
 public:
  Job* first() const { return first_; }
  void append(Job* job);
  void remove(Job* job);

 private:
  Job* first_ = nullptr;
  Job* last_ = nullptr;
};

/// What one principal has of the threads: its queued jobs, and the work done for it.
class Share {
 public:
  /// The rate must outlive the share; null: no limit.
  explicit Share(WorkRate* rate = nullptr) : rate_(rate) {}
  Share(const Share&) = delete;
  Share& operator=(const Share&) = delete;

 private:
  friend class RunQueue;

  std::array<JobList, 4> queues_;  // of short jobs, and of the longer ones of each kind
  std::size_t jobs_ = 0;
  double pass_ = 0;               // work done for it, and what it passed up while it had no jobs
  double shorts_since_long_ = 0;  // work of short jobs since the last slice of a longer one
  Share* next_ = nullptr;         // among the shares with queued jobs
  Share* previous_ = nullptr;
  WorkRate* const rate_;
};

/// Which job is next, by stride scheduling: of the shares with a job that the worker may run, the
/// one for which the least work was done, and among its jobs the first to arrive. Short jobs go
/// before, with two bounds: those of a share that is more than `lead` ahead of another wait like
/// its longer ones, and after `patience` of short work in a share one slice of its longer jobs is
/// due. A share beyond its work rate runs short jobs only. Allocates nothing. Not thread-safe.
class RunQueue {
 public:
  using Time = WorkRate::Time;
  /// Work in instructions.
  static constexpr double lead = 10 * short_work;
  static constexpr double patience = 8 * short_work;
  /// A job that waits counts for at most so much waiting work: about a second of a thread.
  static constexpr double most_waiting = 5e9;
  /// Longer jobs leave so much of a second's work to the calls that come.
  static constexpr WorkRate::Seconds reserve{0.1};

  /// A job whose turn it is.
  struct Turn {
    Job* job = nullptr;  // null: there is none
    Share* share = nullptr;
    JobKind kind = JobKind::sliced;
    bool is_short = false;
  };

  /// Queues a job. True if it is short.
  bool push(Job* job, JobKind kind);
  /// The next job for a worker that runs short jobs and longer ones up to that kind, if any.
  Turn pop(std::optional<JobKind> most, Time now);
  /// After its slice of `work` instructions; `more` queues the job again, without it the job may be
  /// gone.
  void charge(const Turn& turn, double work, bool more, Time now);
  /// Takes a queued job out.
  void remove(Job* job);
  static bool is_queued(const Job* job) { return job->queued_; }

  bool empty() const { return first_ == nullptr; }
  /// From any thread: whether a short job waits.
  bool short_waits() const { return shorts_.load(std::memory_order_relaxed) > 0; }
  /// From any thread: the work of the jobs that wait for a worker, in instructions: what is left of
  /// the price of each, at most `most_waiting`.
  std::uint64_t waiting_work() const { return waiting_.load(std::memory_order_relaxed); }
  /// When the first of those beyond their work rate may go on, that the last `pop` passed over.
  std::optional<Time> ready_at() const { return ready_at_; }
  /// Work rates hold no longer.
  void lift_rates() { lifted_ = true; }

 private:
  Share& share_of(const Job* job) { return job->share_ ? *job->share_ : others_; }
  void enqueue(Job* job);
  Job* first_long(const Share& share, JobKind most, Time now);

  Share others_;            // of jobs without a principal
  Share* first_ = nullptr;  // of the shares with queued jobs
  double served_ = 0;       // the pass of the share that was served last
  std::uint64_t arrivals_ = 0;
  std::atomic<int> shorts_ = 0;
  std::atomic<std::uint64_t> waiting_ = 0;
  std::optional<Time> ready_at_;
  bool lifted_ = false;
};

}  // namespace stiefel::server
