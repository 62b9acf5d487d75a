#pragma once

#include "server/scheduling/scheduler.h"

namespace stiefel::server {

/// Submits jobs of one kind to the scheduler.
class Pool {
 public:
  Pool(Scheduler& scheduler, JobKind kind) : scheduler_(scheduler), kind_(kind) {}

  void submit(Job* job) noexcept { scheduler_.submit(job, kind_); }
  int threads() const { return scheduler_.threads(); }

  /// The price, in instructions, of work that cannot be predicted: about one slice, or ten seconds
  /// for work without slices.
  double price_cap() const { return kind_ == JobKind::unsliced ? unsliced_cap : short_work; }

 private:
  static constexpr double unsliced_cap = 5e10;

  Scheduler& scheduler_;
  const JobKind kind_;
};

}  // namespace stiefel::server
