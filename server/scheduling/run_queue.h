#pragma once

#include <array>
#include <atomic>
#include <optional>

#include "server/scheduling/job.h"

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

/// A principal's share of the threads: its queued jobs, and the work done for it.
class Share {
 public:
  Share() = default;
  Share(const Share&) = delete;
  Share& operator=(const Share&) = delete;

 private:
  friend class RunQueue;

  std::array<JobList, 5> queues_;  // of short jobs, medium ones, and the long ones of each kind
  std::size_t jobs_ = 0;
  std::size_t searches_ = 0;      // unsliced jobs of it that workers are inside
  double pass_ = 0;               // work done for it, and work it forfeited while it had no jobs
  double shorts_since_long_ = 0;  // work of short and medium jobs since a slice of a long one
  Share* next_ = nullptr;         // in the list of shares with queued jobs
  Share* previous_ = nullptr;
};

/// Decides which job runs next, by stride scheduling: of the shares with a job that the worker may
/// run, the one for which the least work was done; in it, the job that arrived first. Short jobs go
/// before medium ones, and both before long ones, with two exceptions. A share that has had more
/// than `lead` more work than another has no precedence for its short and medium jobs. A share that
/// has had `patience` of work for them runs one slice of a long job next. Allocates nothing. Not
/// thread-safe.
class RunQueue {
 public:
  /// Work in instructions.
  static constexpr double lead = 10 * short_work;
  static constexpr double patience = 8 * short_work;
  /// The most work for which a waiting job counts in `waiting_work`: a second of a thread.
  static constexpr double most_waiting = instructions_a_second;
  static_assert(most_waiting == 5e9);  // in the help of the metric stiefel_work_queued

  /// The job to run next.
  struct Turn {
    Job* job = nullptr;  // null if there is none
    Share* share = nullptr;
    JobKind kind = JobKind::sliced;
    JobLength length = JobLength::long_job;
    bool is_search = false;  // whether it counts in Share::searches_
  };

  /// Queues a job; returns its length.
  JobLength push(Job* job, JobKind kind);
  /// Returns the next job for a worker that runs short and medium jobs, and long ones of kinds up
  /// to `most`.
  Turn pop(std::optional<JobKind> most);
  /// Returns the first long job of the least served share that has no worker inside an unsliced
  /// job.
  Turn pop_neglected();
  /// Counts a slice that took `work` instructions. `more` queues the job again; otherwise the job
  /// is not touched and may be destroyed.
  void charge(const Turn& turn, double work, bool more);
  /// Removes a queued job.
  void remove(Job* job);
  static bool is_queued(const Job* job) { return job->queued_; }

  bool empty() const { return first_ == nullptr; }
  /// Whether a short or medium job waits. Thread-safe.
  bool short_waits() const { return shorts_.load(std::memory_order_relaxed) > 0; }
  /// Whether a long job waits. Thread-safe.
  bool long_waits() const { return longs_.load(std::memory_order_relaxed) > 0; }
  /// The work of all waiting jobs in instructions: the unspent part of each price, at most
  /// `most_waiting` a job. Thread-safe.
  std::uint64_t waiting_work() const { return waiting_.load(std::memory_order_relaxed); }

 private:
  Share& share_of(const Job* job) { return job->share_ ? *job->share_ : others_; }
  void enqueue(Job* job);
  static Job* first_long(const Share& share, JobKind most);
  /// Takes the job out for a turn; `extra`: of an extra worker, where it counts as a search.
  Turn begin(Job* job, bool extra = false);

  Share others_;            // of jobs without a principal
  Share* first_ = nullptr;  // the list of the shares with queued jobs
  double served_ = 0;       // the largest pass of a share at its turn
  std::uint64_t arrivals_ = 0;
  std::atomic<int> shorts_ = 0, longs_ = 0;
  std::atomic<std::uint64_t> waiting_ = 0;
};

}  // namespace stiefel::server
