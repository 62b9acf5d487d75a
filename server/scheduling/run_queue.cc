#include "server/scheduling/run_queue.h"

#include <algorithm>

namespace stiefel::server {
namespace {

constexpr std::uint8_t shorts = 0, mediums = 1;
/// Returns the index of the queue for long jobs of a kind.
std::uint8_t queue_of(JobKind kind) {
  return static_cast<std::uint8_t>(2 + static_cast<std::uint8_t>(kind));
}
std::uint8_t queue_of(JobLength length, JobKind kind) {
  return length == JobLength::long_job ? queue_of(kind) : static_cast<std::uint8_t>(length);
}

/// Returns the work left of a job in instructions; one slice if it has taken more than its price.
std::uint64_t work_left(double price, double spent) {
  return static_cast<std::uint64_t>(price > spent ? std::min(price - spent, RunQueue::most_waiting)
                                                  : short_work);
}

}  // namespace

void JobList::append(Job* job) {
  job->next_ = nullptr;
  job->previous_ = last_;
  (last_ ? last_->next_ : first_) = job;
  last_ = job;
}

void JobList::remove(Job* job) {
  (job->previous_ ? job->previous_->next_ : first_) = job->next_;
  (job->next_ ? job->next_->previous_ : last_) = job->previous_;
}

JobLength RunQueue::push(Job* job, JobKind kind) {
  job->kind_ = kind;
  enqueue(job);
  return job->length();
}

void RunQueue::enqueue(Job* job) {
  Share& share = share_of(job);
  job->order_ = ++arrivals_;
  job->queue_ = queue_of(job->length(), job->kind_);
  job->queued_ = true;
  job->waiting_ = work_left(job->price_, job->spent_);
  waiting_.fetch_add(job->waiting_, std::memory_order_relaxed);
  share.queues_[job->queue_].append(job);
  (job->queue_ <= mediums ? shorts_ : longs_).fetch_add(1, std::memory_order_relaxed);
  if (share.jobs_++ > 0) return;
  // A share forfeits the work that it could have had while it had no jobs.
  share.pass_ = std::max(share.pass_, served_);
  share.previous_ = nullptr;
  share.next_ = first_;
  if (first_) first_->previous_ = &share;
  first_ = &share;
}

void RunQueue::remove(Job* job) {
  Share& share = share_of(job);
  share.queues_[job->queue_].remove(job);
  job->queued_ = false;
  waiting_.fetch_sub(job->waiting_, std::memory_order_relaxed);
  (job->queue_ <= mediums ? shorts_ : longs_).fetch_sub(1, std::memory_order_relaxed);
  if (--share.jobs_ > 0) return;
  (share.previous_ ? share.previous_->next_ : first_) = share.next_;
  if (share.next_) share.next_->previous_ = share.previous_;
}

Job* RunQueue::first_long(const Share& share, JobKind most) {
  Job* first = nullptr;
  for (std::uint8_t queue = mediums + 1; queue <= queue_of(most); ++queue) {
    Job* job = share.queues_[queue].first();
    if (job && (!first || job->order_ < first->order_)) first = job;
  }
  return first;
}

RunQueue::Turn RunQueue::pop(std::optional<JobKind> most) {
  const Share* fair = nullptr;  // the share for which the least was done
  Job* fallback = nullptr;      // the first long job of `fair`, or the first other one
  // The first job that goes before long ones: a short one, else a medium one, of the least served
  // share.
  Job* quick = nullptr;
  for (Share* share = first_; share; share = share->next_) {
    Job* first = most ? first_long(*share, *most) : nullptr;
    Job* brief = share->queues_[shorts].first();
    if (!brief) brief = share->queues_[mediums].first();
    if (!first && !brief) continue;
    if (!fair || share->pass_ < fair->pass_) {
      fair = share;
      fallback = first ? first : brief;
    }
    const bool due = first && share->shorts_since_long_ > patience;
    if (brief && !due &&
        (!quick || brief->queue_ < quick->queue_ ||
         (brief->queue_ == quick->queue_ && share->pass_ < share_of(quick).pass_)))
      quick = brief;
  }
  if (!fair) return {};
  served_ = std::max(served_, fair->pass_);
  const bool before = quick && share_of(quick).pass_ <= fair->pass_ + lead;
  return begin(before ? quick : fallback);
}

RunQueue::Turn RunQueue::begin(Job* job, bool extra) {
  remove(job);
  Share& share = share_of(job);
  const auto length = std::min(static_cast<JobLength>(job->queue_), JobLength::long_job);
  const bool is_search = extra || job->kind_ == JobKind::unsliced;
  share.searches_ += is_search;
  return {job, &share, job->kind_, length, is_search};
}

RunQueue::Turn RunQueue::pop_neglected() {
  Job* job = nullptr;
  for (const Share* share = first_; share; share = share->next_) {
    if (share->searches_ > 0 || (job && share->pass_ >= share_of(job).pass_)) continue;
    if (Job* first = first_long(*share, JobKind::unsliced)) job = first;
  }
  return job ? begin(job, true) : Turn();
}

void RunQueue::charge(const Turn& turn, double work, bool more) {
  Share& share = *turn.share;
  share.searches_ -= turn.is_search;
  share.pass_ += work;
  share.shorts_since_long_ =
      turn.length == JobLength::long_job ? 0 : share.shorts_since_long_ + work;
  if (!more) return;
  turn.job->spent_ += work;
  enqueue(turn.job);
}

}  // namespace stiefel::server
