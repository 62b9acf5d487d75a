#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>

#include "server/sessions/session.h"

namespace stiefel::server {

/// A Simulation leased from a session, on its way from step to step. Leaves checkpoints behind.
/// For one thread at a time.
class Cursor {
 public:
  /// Starts at the nearest state at or before `to`. The session must outlive the cursor. Throws
  /// Stopped (stiefel/stop.h) when `stop` requests it while an ensemble's simulation is made, which
  /// takes 10 µs a member.
  Cursor(Session& session, std::int64_t to, const std::stop_token& stop = {})
      : session_(&session),
        simulation_(lease(session, to, stop)),
        start_(simulation_->step()),
        mark_(session.next_checkpoint(simulation_->step())) {}
  Cursor(Cursor&&) = default;
  Cursor& operator=(Cursor&&) = delete;
  ~Cursor() {
    if (simulation_) session_->give_back(std::move(simulation_));
  }

  /// Goes towards `to`, not before where it is, but at most `budget` steps, which it takes from
  /// `budget`. True when it is there or cannot go on: see `run_status`, which is `cancelled` when
  /// it was asked to stop.
  bool advance(std::int64_t to, std::int64_t& budget, const std::stop_token& stop = {});
  /// Ends the cursor where it is.
  void cancel() {
    wake();
    end(RunStatus{Outcome::cancelled, std::nullopt});
  }

  /// Gives the simulation back while the reader is not ready or another call has the processor, and
  /// keeps only its state: a simulation of large N has many times as many numbers. `advance` and
  /// `cancel` take one up again; until then there is neither `simulation` nor `step`. Small
  /// simulations stay.
  void rest();

  const RunStatus& run_status() const { return run_status_; }
  /// The step of the state that it began with.
  std::int64_t start() const { return start_; }
  const Simulation& simulation() const { return *simulation_; }
  std::int64_t step() const { return simulation_->step(); }
  /// `Simulation::rate` at the last good state of a cursor that left the domain; else 0.
  double rate() const { return rate_; }
  std::int64_t computed_steps() const { return computed_; }
  /// A rough guess, from the scene alone.
  double nanoseconds_to(std::int64_t to) const {
    if (simulation_->direct()) return session_->step_cost();
    return static_cast<double>(to - step()) * session_->step_cost();
  }

 private:
  static std::unique_ptr<Simulation> lease(Session& session, std::int64_t to,
                                           const std::stop_token& stop);
  void wake();
  /// So many steps.
  void go(std::int64_t steps, const std::stop_token& stop);
  void end(const RunStatus& run_status);

  Session* session_;
  std::unique_ptr<Simulation> simulation_;
  std::int64_t start_;
  std::int64_t rested_at_ = 0;
  Saved rested_;  // the state while there is no simulation
  std::int64_t mark_;
  std::int64_t computed_ = 0;
  RunStatus run_status_;
  double rate_ = 0;
};

}  // namespace stiefel::server
