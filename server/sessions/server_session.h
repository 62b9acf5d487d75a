#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/scheduling/memory_budget.h"
#include "server/sessions/checkpoints/checkpoints.h"
#include "server/sessions/identity.h"
#include "server/sessions/write_ahead_log.h"
#include "stiefel/price.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"

namespace stiefel::server {

using Clock = std::function<std::chrono::steady_clock::time_point()>;

/// A field that is not finite at step 0.
struct Overflow {
  std::string field;
  double value;
};

/// A pure function from step index to state: the scene and a cache of states to start from. No lock
/// is held during a computation: a caller leases a Simulation, advances it and gives it back, so
/// several callers can use one session at once. Thread-safe.
class Session : public std::enable_shared_from_this<Session> {
 public:
  static constexpr std::int64_t max_step = std::int64_t{1} << 53;

  /// `memory` must outlive the session. Throws MemoryExhausted when the scene, its state and its
  /// simulation do not fit into `memory`, as do `lease`, `lease_at` and `adopt`.
  Session(std::string id, Scene scene, std::shared_ptr<const Clock> clock,
          Resolution resolution = {}, MemoryBudget& memory = MemoryBudget::unlimited());

  const std::string& id() const { return id_; }
  const Scene& scene() const { return scene_; }
  /// How the scene was resolved from what the session's creator gave.
  const Resolution& resolution() const { return resolution_; }
  /// SHA-256 of the resolved scene, 32 bytes: equal exactly for equal scenes.
  const std::string& identity() const { return identity_; }
  /// Simulation::fields.
  const std::vector<Field>& fields() const { return fields_; }
  /// The indices of the fields that are reported where none are named.
  const std::vector<std::size_t>& default_fields() const { return default_fields_; }
  std::size_t saved_size() const { return saved_size_; }
  double step_cost() const { return step_cost_; }
  /// stiefel::warnings of the scene.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// Whether every state is computed directly from that at step 0, however far away it is.
  bool direct() const { return direct_; }
  /// The predicted work of a step in instructions. A `direct` session takes as much to any state.
  double step_work() const { return step_work_; }
  /// A field that is not finite at step 0, where 1/λ or λ_i + λ_j overflows.
  const std::optional<Overflow>& overflow() const { return overflow_; }

  /// Keeps the session's permit from its principal's account until the session is destroyed. Call
  /// it once.
  void hold_permit(std::shared_ptr<void> permit) { permit_ = std::move(permit); }

  /// Returns a Simulation at the nearest state at or before `step`, for the caller alone.
  std::unique_ptr<Simulation> lease(std::int64_t step);
  /// Returns a Simulation in the state `saved`, which `Simulation::save` wrote at `step`.
  std::unique_ptr<Simulation> lease_at(std::int64_t step, std::span<const double> saved);
  void give_back(std::unique_ptr<Simulation> simulation) noexcept;
  /// Destroys a leased simulation that an exception left between two states; call it in place of
  /// `give_back`.
  void discard(std::unique_ptr<Simulation> simulation) noexcept {
    if (!simulation) return;
    simulation.reset();
    simulations_memory_.shrink(simulation_bytes_);
  }
  /// Returns a copy of the simulation's state, from which `lease_at` makes a simulation again.
  /// Callers at the same step share one copy. Null when there is no memory for it.
  Saved keep(const Simulation& simulation);

  /// The predicted bytes of the scene, and 8 KiB for the session itself.
  std::uint64_t scene_bytes() const { return scene_memory_.bytes(); }
  /// The predicted bytes of one simulation of the scene.
  std::uint64_t simulation_bytes() const { return simulation_bytes_; }
  /// The bytes that `evict` would give back.
  std::uint64_t cached_bytes() const;
  /// Drops what can be computed again: idle simulations, and the checkpoints that are neither at
  /// step 0 nor a client's.
  void evict();

  /// Returns the first step after `step` where `deposit` would keep the state.
  std::int64_t next_checkpoint(std::int64_t step) const {
    const std::int64_t spacing = spacing_.load(std::memory_order_relaxed);
    return (step / spacing + 1) * spacing;
  }
  /// Keeps the state if its step is one of the fixed indices and there is memory for it.
  void deposit(const Simulation& simulation);
  /// Keeps a state from a client's checkpoint: `saved_size()` numbers.
  void adopt(std::int64_t step, std::vector<double> saved);
  /// Keeps a state from the store in the cache if there is memory for it; `evict` drops it.
  void adopt_if_it_fits(std::int64_t step, std::span<const double> saved);

  /// Returns the steps of the cached states in increasing order, from 0.
  std::vector<std::int64_t> cached_steps() const;
  /// The step at which the last call left its simulation.
  std::int64_t cursor() const { return cursor_.load(std::memory_order_relaxed); }

  std::chrono::system_clock::time_point create_time() const { return create_time_; }
  /// Sets the owner. Call it before other threads see the session.
  void set_owner(Principal owner) { owner_ = std::move(owner); }
  /// Sets the creation time of a restored session. Call it before other threads see the session.
  void set_create_time(std::chrono::system_clock::time_point created) { create_time_ = created; }
  /// Reports new cached states to `log`. Call it before other threads use the session.
  void write_to(WriteAheadLog& log) { log_ = &log; }
  const Principal& owner() const { return owner_; }
  /// Sets the pending write of this session, null without a store, and reports a cached state after
  /// step 0. Guarded by the registry's lock.
  void written_by(std::shared_ptr<PendingWrite> pending_write) {
    pending_write_ = std::move(pending_write);
    if (cached_steps().back() > 0) tell_log();
  }
  const std::shared_ptr<PendingWrite>& pending_write() const { return pending_write_; }
  /// Returns the last cached state, and reports the next one again.
  Checkpoints::Nearest take_last_state() {
    reported_to_log_ = false;
    const std::lock_guard lock(mutex_);
    return checkpoints_.nearest(max_step);
  }
  std::chrono::steady_clock::duration idle_time() const {
    if (in_use()) return {};
    const std::chrono::steady_clock::duration last(last_use_.load());
    return (*clock_)().time_since_epoch() - last;
  }
  bool in_use() const { return uses_.load() > 0; }
  /// Whether the session is deleted or expired: running calls go on, new ones do not find it.
  bool closed() const { return closed_.load(std::memory_order_relaxed); }
  void close() { closed_ = true; }

 private:
  friend class SessionLease;
  void tell_log();
  void touch() { last_use_ = (*clock_)().time_since_epoch().count(); }
  std::unique_ptr<Simulation> make();
  /// Sets what the outline has, and the spacing of the checkpoints from it.
  void set_outline(Outline outline);
  /// Reads what the constructor of an ensemble needs from one member after another.
  void read_members();
  /// Sets the work of a step from one of the `members`, or from the scene itself:
  /// `rate` is the largest ‖Ω‖ at the start.
  void set_work(const Scene& one, std::size_t members, double rate);
  /// Steps of the map between two states.
  double map_steps() const { return direct_ ? 1 : scene_.substeps(); }
  /// Returns `simulation`, or a new one if it is null, in the state `saved` at `step`.
  std::unique_ptr<Simulation> at_state(std::unique_ptr<Simulation> simulation, std::int64_t step,
                                       std::span<const double> saved);

  MemoryBudget& memory_;
  const std::string id_;
  const Scene scene_;
  const Resolution resolution_;
  const std::string identity_;
  const std::shared_ptr<const Clock> clock_;
  std::shared_ptr<void> permit_;
  std::chrono::system_clock::time_point create_time_ = std::chrono::system_clock::now();
  Principal owner_;
  WriteAheadLog* log_ = nullptr;
  std::shared_ptr<PendingWrite> pending_write_;
  std::atomic<bool> reported_to_log_ = false;  ///< a cached state that it has not taken yet
  const std::uint64_t simulation_bytes_;
  const MemoryLease scene_memory_;
  MemoryLease simulations_memory_;  ///< of the idle and of the leased simulations
  std::vector<Field> fields_;
  std::vector<std::size_t> default_fields_;
  std::size_t saved_size_ = 0;
  double step_cost_ = 1;
  double step_work_ = 0;
  const std::vector<std::string> warnings_;
  bool direct_ = false;
  std::optional<Overflow> overflow_;

  std::atomic<std::int64_t> cursor_ = 0;
  std::atomic<std::int64_t> spacing_ = 1;
  std::atomic<std::chrono::steady_clock::rep> last_use_ = 0;
  std::atomic<int> uses_ = 0;
  std::atomic<bool> closed_ = false;

  mutable std::mutex mutex_;
  Checkpoints checkpoints_;                        // guarded by mutex_
  std::vector<std::unique_ptr<Simulation>> idle_;  // guarded by mutex_; the last used at the back
  /// The states of resting callers, by step.
  std::map<std::int64_t, std::weak_ptr<const std::vector<double>>> kept_;  // guarded by mutex_
};

/// A session in use: it does not expire during the lease, and its idle time starts again
/// afterwards.
class SessionLease {
 public:
  explicit SessionLease(std::shared_ptr<Session> session) : session_(std::move(session)) {
    ++session_->uses_;
    session_->touch();
  }
  SessionLease(SessionLease&&) = default;
  SessionLease& operator=(SessionLease&& other) noexcept {
    std::swap(session_, other.session_);
    return *this;
  }
  ~SessionLease() {
    if (!session_) return;
    session_->touch();
    --session_->uses_;
  }

  /// The session, for a use after the lease; it may expire in between.
  const std::shared_ptr<Session>& session() const { return session_; }
  Session* operator->() const { return session_.get(); }
  Session& operator*() const { return *session_; }

 private:
  std::shared_ptr<Session> session_;
};

}  // namespace stiefel::server
