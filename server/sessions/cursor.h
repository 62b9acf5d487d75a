#pragma once

#include <cstdint>
#include <stop_token>

#include "server/sessions/server_session.h"

namespace stiefel::server {

/// Acquires a Simulation from a session, advances it and puts checkpoints into the session on the
/// way. For one thread at a time.
class Cursor {
 public:
  /// Acquires a simulation at the nearest state at or before `to`. The session must outlive the
  /// cursor. To make the simulation of an ensemble takes 1 to 60 µs a member, with stop points
  /// (stiefel/stop.h).
  Cursor(Session& session, std::int64_t to)
      : session_(&session),
        simulation_(session.acquire(to)),
        start_(simulation_->step()),
        mark_(session.next_checkpoint(simulation_->step())) {}
  Cursor(Cursor&&) = default;
  Cursor& operator=(Cursor&&) = delete;
  ~Cursor();

  /// Advances towards `to` by at most `budget` steps, never backwards, and subtracts the steps from
  /// `budget`; a closed form counts as one step. An ensemble advances by slices of at most that
  /// many steps (Simulation::advance_slice); the budget is used up when one ends while members are
  /// on their way. Returns true when the cursor is at `to` or cannot go on: see `run_status`, which
  /// is `cancelled` after a stop request.
  bool advance(std::int64_t to, std::int64_t& budget, const std::stop_token& stop = {});
  /// Ends the run at the current step with the outcome `cancelled`.
  void cancel();

  /// Releases the simulation and keeps only a snapshot of its state, while the reader is not ready
  /// or another call has the processor: a simulation of large N holds many times as many numbers as
  /// its state. `advance` and `cancel` acquire a simulation again; until then neither `simulation`
  /// nor `step` may be called. Does nothing when the state has fewer than 8192 numbers, when
  /// members are on their way, or when there is no memory for a copy.
  void suspend();
  /// Whether the session is so large that `suspend` releases the simulation.
  static bool is_large(const Session& session);

  const RunStatus& run_status() const { return run_status_; }
  /// Whether a stop request or `cancel` ended the run.
  bool stopped() const { return run_status_.outcome == Outcome::cancelled; }
  /// The step of the state from which the cursor started.
  std::int64_t start() const { return start_; }
  const Simulation& simulation() const { return *simulation_; }
  std::int64_t step() const { return simulation_->step(); }
  /// `Simulation::rate` at the last good state if the run left the domain, otherwise 0.
  double rate() const { return rate_; }
  std::int64_t computed_steps() const { return computed_; }

 private:
  void resume();
  void end(const RunStatus& run_status);

  Session* session_;
  SimulationPtr simulation_;
  bool on_the_way_ = false;  // Simulation::advance_slice has not returned a status
  std::int64_t start_;
  std::int64_t suspended_at_ = 0;
  Saved snapshot_;  // the state at suspended_at_ while simulation_ is null
  std::int64_t mark_;
  std::int64_t computed_ = 0;
  RunStatus run_status_;
  double rate_ = 0;
};

}  // namespace stiefel::server
