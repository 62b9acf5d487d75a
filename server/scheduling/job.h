#pragma once

#include <cstdint>

namespace stiefel::server {

class Share;

/// The length of a job's slices, which decides which workers may run it.
enum class JobKind : std::uint8_t {
  brief,     ///< as short as `brief_slice_nanoseconds`
  sliced,    ///< about `slice_nanoseconds`
  unsliced,  ///< longer, up to seconds: a search, or one step of a large body
};

/// The nominal speed of one thread, which converts between its processor time and work.
inline constexpr double instructions_a_nanosecond = 5;
inline constexpr double instructions_a_second = 1e9 * instructions_a_nanosecond;

/// The most predicted work, in instructions, of a short call, which goes before all others: about
/// one slice. Up to `medium_work`, about ten slices, it goes before longer ones.
inline constexpr double short_work = 1e7, medium_work = 10 * short_work;

/// Returns the price, in instructions, of work that cannot be predicted, for a job of that kind:
/// about one slice, or ten seconds for work without slices.
inline double price_cap(JobKind kind) { return kind == JobKind::unsliced ? 5e10 : short_work; }

/// Which jobs go before others.
enum class JobLength : std::uint8_t { short_job, medium, long_job };

/// Long work that the scheduler runs in short slices.
class Job {
 public:
  virtual ~Job() = default;
  /// Runs one slice. Returns true to be queued again; after false the scheduler no longer touches
  /// the job, which may be destroyed already.
  virtual bool run_slice() noexcept = 0;

 protected:
  /// Sets, before `submit`, whose share of the threads the job takes and its predicted work in
  /// instructions. The share must outlive the job. A job that never calls it is short and takes the
  /// share of the jobs without a principal.
  void bill(Share& share, double price) {
    share_ = &share;
    price_ = price;
    spent_ = 0;
  }

 private:
  friend class JobList;
  friend class RunQueue;
  friend class Scheduler;

  /// Returns the length by the work that is left of the price. A job is long once it has taken more
  /// than its price and more than `short_work`.
  JobLength length() const {
    if (kind_ == JobKind::unsliced || (spent_ > short_work && spent_ >= price_))
      return JobLength::long_job;
    if (price_ - spent_ <= short_work) return JobLength::short_job;
    return price_ - spent_ <= medium_work ? JobLength::medium : JobLength::long_job;
  }

  Job* next_ = nullptr;  // in a queue
  Job* previous_ = nullptr;
  Share* share_ = nullptr;
  std::uint64_t order_ = 0;    // of arrival
  std::uint64_t waiting_ = 0;  // its part of RunQueue::waiting_work while it is queued
  double price_ = 0;
  double spent_ = 0;
  JobKind kind_ = JobKind::sliced;
  std::uint8_t queue_ = 0;  // its queue in the share, while it is queued
  bool queued_ = false;
  bool cancelled_ = false;  // guarded by the scheduler's mutex
};

}  // namespace stiefel::server
