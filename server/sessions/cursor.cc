#include "server/sessions/cursor.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "server/scheduling/slice.h"
#include "stiefel/simulation.h"

namespace stiefel::server {
namespace {

/// The least numbers of a state at which it repays to make the simulation anew.
constexpr std::size_t least_to_suspend = 8192;

}  // namespace

Cursor::~Cursor() {
  if (!simulation_) return;
  try {
    if (on_the_way_) simulation_->turn_back();
  } catch (const std::exception&) {  // no memory to turn back
    return;
  }
  session_->release(std::move(simulation_));
}

void Cursor::cancel() {
  resume();
  if (std::exchange(on_the_way_, false)) simulation_->turn_back();
  end(RunStatus{Outcome::cancelled, std::nullopt});
}

bool Cursor::is_large(const Session& session) { return session.saved_size() >= least_to_suspend; }

void Cursor::suspend() {
  if (!simulation_ || on_the_way_ || !is_large(*session_)) return;
  snapshot_ = session_->snapshot(*simulation_);
  if (!snapshot_) return;
  suspended_at_ = simulation_->step();
  session_->release(std::move(simulation_));
}

void Cursor::resume() {
  if (simulation_) return;
  simulation_ = session_->acquire(suspended_at_, snapshot_);
  snapshot_.reset();
}

void Cursor::end(const RunStatus& run_status) {
  run_status_ = run_status;
  if (run_status.outcome == Outcome::left_domain) rate_ = rate_at(run_status, *simulation_);
}

bool Cursor::advance(std::int64_t to, std::int64_t& budget, const std::stop_token& stop) {
  resume();
  const bool direct = simulation_->direct();  // no checkpoint would be nearer
  for (std::int64_t at = simulation_->step(); at < to;) {
    if (!run_status_.reached()) return true;
    if (budget <= 0) return false;
    const std::int64_t steps = direct ? to - at : std::min(to - at, mark_ - at);
    const double slice =
        std::min(static_cast<double>(budget), slice_fraction(session_->step_cost()));
    try {
      const auto status = simulation_->advance_slice(steps, slice, stop);
      on_the_way_ = !status;
      if (status) end(*status);
    } catch (...) {
      // The simulation has no valid state after an exception in the middle of a step.
      simulation_ = {};
      throw;
    }
    if (on_the_way_) {
      budget = 0;
      continue;
    }
    const std::int64_t moved = simulation_->step() - at;
    at += moved;
    computed_ += direct ? 1 : moved;
    budget -= direct ? 1 : std::max<std::int64_t>(moved, 1);
    if (at != mark_ || direct) continue;
    session_->put_checkpoint(*simulation_);
    mark_ = session_->next_checkpoint(at);
  }
  return true;
}

}  // namespace stiefel::server
