#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <type_traits>
#include <utility>

#include "server/sessions/server_session.h"
#include "stiefel/stop.h"

namespace stiefel::server {

/// Returns what `work()` computes in the engine, or nothing when `stop` is requested before it
/// ends.
template <class Work>
std::optional<std::invoke_result_t<Work>> stoppable(const std::stop_token& stop, Work&& work) {
  return unless_stopped(stop, std::forward<Work>(work));
}

/// Leases a Simulation from a session, advances it and deposits checkpoints in the session on the
/// way. For one thread at a time.
class Cursor {
 public:
  /// Leases a simulation at the nearest state at or before `to`. The session must outlive the
  /// cursor. Throws Stopped (stiefel/stop.h) when `stop` is requested while the simulation of an
  /// ensemble is made, which takes 10 µs a member. The price is that of a call which goes to `to`.
  Cursor(Session& session, std::int64_t to, const std::stop_token& stop = {})
      : session_(&session),
        simulation_(lease(session, to, stop)),
        start_(simulation_->step()),
        mark_(session.next_checkpoint(simulation_->step())) {
    price_to(to);
  }
  Cursor(Cursor&&) = default;
  Cursor& operator=(Cursor&&) = delete;
  ~Cursor();

  /// Sets the price to that of a call which goes to `to`, where the session has an AttemptLimit.
  void price_to(std::int64_t to);

  /// Advances towards `to` by at most `budget` steps, never backwards, and subtracts the steps from
  /// `budget`; a closed form counts as one step. An ensemble advances by slices of at most that
  /// many steps (Simulation::advance_slice); the budget is used up when one ends while members are
  /// on their way. Returns true when the cursor is at `to` or cannot go on: see `run_status`, which
  /// is `cancelled` after a stop request. Throws PriceReached between two steps.
  bool advance(std::int64_t to, std::int64_t& budget, const std::stop_token& stop = {});
  /// Ends the run at the current step with the outcome `cancelled`.
  void cancel();

  /// Gives the simulation back and keeps only its state, while the reader is not ready or another
  /// call has the processor: a simulation of large N holds many times as many numbers as its state.
  /// `advance` and `cancel` lease a simulation again; until then neither `simulation` nor `step`
  /// may be called. Does nothing when the state has fewer than 8192 numbers, when members are on
  /// their way, or when there is no memory for a copy.
  void rest();
  /// Whether the session is so large that `rest` gives the simulation back.
  static bool is_large(const Session& session);
  bool rests() const { return !simulation_; }

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
  /// Returns a rough estimate of the time to `to` in nanoseconds, from the scene alone.
  double nanoseconds_to(std::int64_t to) const {
    if (simulation_->direct()) return session_->step_cost();
    return static_cast<double>(to - step()) * session_->step_cost();
  }

 private:
  static std::unique_ptr<Simulation> lease(Session& session, std::int64_t to,
                                           const std::stop_token& stop);
  void wake();
  /// Returns the most steps that may be computed before the price is compared again. Throws
  /// PriceReached.
  std::int64_t steps_within_price() const;
  void end(const RunStatus& run_status);

  Session* session_;
  std::unique_ptr<Simulation> simulation_;
  bool on_the_way_ = false;  // Simulation::advance_slice has not returned a status
  std::int64_t start_;
  std::int64_t rested_at_ = 0;
  Saved rested_;  // the state at rested_at_ while simulation_ is null
  std::int64_t mark_;
  std::int64_t computed_ = 0;
  std::optional<AttemptLimit> limit_;
  double attempts_ = 0;              // tried so far
  std::int64_t tried_ = 0;           // map steps of the simulation before those of this advance
  std::int64_t steps_to_price_ = 0;  // the steps of the call, which determine its price
  RunStatus run_status_;
  double rate_ = 0;
};

}  // namespace stiefel::server
