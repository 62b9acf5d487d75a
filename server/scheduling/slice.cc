#include "server/scheduling/slice.h"

#include <algorithm>
#include <utility>

namespace stiefel::server {
namespace {

thread_local double length = slice_nanoseconds;

}  // namespace

std::int64_t slice_steps(double step_cost) {
  return static_cast<std::int64_t>(std::max(1.0, length / std::max(step_cost, 1.0)));
}

JobKind kind_of_steps(double step_cost) {
  if (step_cost <= brief_slice_nanoseconds) return JobKind::brief;
  return step_cost <= slice_nanoseconds ? JobKind::sliced : JobKind::unsliced;
}

SliceLength::SliceLength(double nanoseconds) : previous_(std::exchange(length, nanoseconds)) {}
SliceLength::~SliceLength() { length = previous_; }

}  // namespace stiefel::server
