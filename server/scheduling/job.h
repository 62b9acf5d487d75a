#pragma once

#include <cstdint>
#include <limits>

namespace stiefel::server {

class Share;

/// How long a slice of a job is, which decides the workers that may run it.
enum class JobKind : std::uint8_t {
  brief,   ///< as short as `brief_slice_nanoseconds`
  sliced,  ///< about `slice_nanoseconds`
  whole,   ///< longer, up to seconds: a search, or one step of a large body
};

/// Work in instructions that a call may be predicted to take and still go before longer ones: about
/// one slice.
inline constexpr double short_work = 1e7;

/// Long work in short slices.
class Job {
 public:
  virtual ~Job() = default;
  /// Does one slice. True: queue it again. False: the scheduler forgets the job, which may be gone
  /// by then.
  virtual bool run_slice() noexcept = 0;

 protected:
  /// Says before `submit` whose share of the threads the job takes, which outlives the job, and the
  /// work it is predicted to take, in instructions. A job that says nothing is short and takes the
  /// share of those without a principal.
  void bill(Share& share, double price) {
    share_ = &share;
    price_ = price;
    spent_ = 0;
  }
  /// A job that never goes before others.
  static constexpr double no_price = std::numeric_limits<double>::infinity();

 private:
  friend class JobList;
  friend class RunQueue;

  /// A job that took more than its price and more than a short one may is long from then on.
  bool is_short() const {
    return kind_ != JobKind::whole && price_ - spent_ <= short_work &&
           (spent_ <= short_work || spent_ < price_);
  }

  Job* next_ = nullptr;  // in a queue
  Job* previous_ = nullptr;
  Share* share_ = nullptr;
  std::uint64_t order_ = 0;    // of arrival
  std::uint64_t waiting_ = 0;  // what it counts in RunQueue::waiting_work while it is queued
  double price_ = 0;
  double spent_ = 0;
  JobKind kind_ = JobKind::sliced;
  std::uint8_t queue_ = 0;  // which of its share's, while it is queued
  bool queued_ = false;
};

}  // namespace stiefel::server
