#pragma once

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

#include "engine/simulation/run/outline.h"
#include "server/limits/memory_budget.h"
#include "server/sessions/checkpoints/checkpoints.h"
#include "server/sessions/ledger.h"
#include "server/sessions/resolution.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"

namespace stiefel::server {

class CheckpointKeys;

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

  /// `keys`: of its checkpoints; those of the process if null. Throws MemoryExhausted, as all that
  /// makes simulations or keeps states does, when its scene, state and simulation do not fit into
  /// the budget, which must outlive it.
  Session(std::string id, Scene scene, std::shared_ptr<const Clock> clock,
          Resolution resolution = {}, std::shared_ptr<const CheckpointKeys> keys = nullptr,
          MemoryBudget& memory = MemoryBudget::unlimited());

  const std::string& id() const { return id_; }
  const Scene& scene() const { return scene_; }
  /// How the scene came from what the session's creator gave.
  const Resolution& resolution() const { return resolution_; }
  /// Equal exactly for equal resolved scenes: 32 bytes.
  const std::string& identity() const { return identity_; }
  const CheckpointKeys& checkpoint_keys() const { return *keys_; }
  const std::vector<Field>& fields() const { return fields_; }
  std::size_t block_count() const { return block_count_; }
  std::size_t saved_size() const { return saved_size_; }
  double step_cost() const { return step_cost_; }
  /// Whether a state is computed from that at step 0, however far.
  bool direct() const { return direct_; }
  /// Units of work, instructions, that the steps between two states are predicted to take; where a
  /// method chooses its own steps, at least.
  double work(std::int64_t from, std::int64_t to) const;
  /// A field that is not finite at step 0, if there is one: 1/λ or λ_i + λ_j of numbers that were
  /// themselves in order.
  const std::optional<Overflow>& overflow() const { return overflow_; }

  /// The step of the nearest state at or before `step`: where `lease` would begin now.
  std::int64_t start_for(std::int64_t step) const;
  /// What is given back when the session is gone: its place in its principal's account. Once, by
  /// the call that made it.
  void hold(std::shared_ptr<void> seat) { seat_ = std::move(seat); }

  /// A Simulation at the nearest state at or before `step`, for the caller alone.
  std::unique_ptr<Simulation> lease(std::int64_t step);
  /// One with that state, which `save` gave at `step`.
  std::unique_ptr<Simulation> lease_at(std::int64_t step, std::span<const double> saved);
  void give_back(std::unique_ptr<Simulation> simulation) noexcept;
  /// Instead of `give_back`: of one that an exception left between two states.
  void discard(std::unique_ptr<Simulation> simulation) noexcept;
  /// The state of a simulation for a caller that rests: callers that rest at one step share it.
  /// Null when there is no memory for it.
  Saved keep(const Simulation& simulation);

  /// Bytes that the scene takes, predicted.
  std::uint64_t scene_bytes() const { return scene_memory_.bytes(); }
  /// Bytes that a simulation of the scene takes, predicted.
  std::uint64_t simulation_bytes() const { return simulation_bytes_; }
  /// Bytes of what `shed` would give up.
  std::uint64_t cached_bytes() const;
  /// Gives up what can be computed again: idle simulations, and the checkpoints after step 0 that
  /// did not come from elsewhere.
  void shed();

  /// The first step after `step` where `deposit` would keep the state.
  std::int64_t next_checkpoint(std::int64_t step) const;
  /// Keeps the state if its step is one of the fixed indices.
  void deposit(const Simulation& simulation);
  /// Keeps a state that came from elsewhere; `saved_size()` numbers.
  void adopt(std::int64_t step, std::vector<double> saved);

  /// The steps of the states that it caches, step 0 first.
  std::vector<std::int64_t> cached_steps() const;
  /// The step that the last call left it at.
  std::int64_t cursor() const { return cursor_.load(std::memory_order_relaxed); }

  std::chrono::system_clock::time_point create_time() const { return create_time_; }
  /// Before others see the session.
  void belong_to(const Principal& owner) { owner_ = owner; }
  /// Before others see the session: from now on the ledger learns of the states that it caches.
  void write_to(Ledger& ledger) { ledger_ = &ledger; }
  /// Before others see the session: whose it is and when it was created, by a server before this
  /// one.
  void restored(Principal owner, std::chrono::system_clock::time_point created) {
    owner_ = std::move(owner);
    create_time_ = created;
  }
  const Principal& owner() const { return owner_; }
  /// Of its row in the ledger; null without one. Guarded by the registry's lock.
  void written_by(std::shared_ptr<Receipt> receipt);
  const std::shared_ptr<Receipt>& receipt() const { return receipt_; }
  /// The last state that it caches; the ledger learns of the next one again.
  Checkpoints::Nearest take_last_state();
  std::chrono::steady_clock::duration idle_time() const;
  bool in_use() const { return uses_.load() > 0; }
  /// Deleted or expired: calls that run go on, new ones do not find it.
  bool closed() const { return closed_.load(std::memory_order_relaxed); }
  void close() { closed_ = true; }

 private:
  friend class SessionLease;
  void tell_ledger();
  void touch() { last_use_ = (*clock_)().time_since_epoch().count(); }
  std::unique_ptr<Simulation> make();
  void take(Outline outline);
  /// Instead of making the simulation of an ensemble.
  void look_at_members();
  /// Steps of the map between two states.
  double map_steps() const { return direct_ ? 1 : scene_.substeps(); }
  /// That simulation, or a new one where it is null, at that state.
  std::unique_ptr<Simulation> at_state(std::unique_ptr<Simulation> simulation, std::int64_t step,
                                       std::span<const double> saved);

  MemoryBudget& memory_;
  const std::string id_;
  const Scene scene_;
  const Resolution resolution_;
  const std::string identity_;
  const std::shared_ptr<const Clock> clock_;
  const std::shared_ptr<const CheckpointKeys> keys_;
  std::shared_ptr<void> seat_;
  std::chrono::system_clock::time_point create_time_ = std::chrono::system_clock::now();
  Principal owner_;
  Ledger* ledger_ = nullptr;
  std::shared_ptr<Receipt> receipt_;
  std::atomic<bool> ledger_knows_ = false;  // that there is a state it has not taken
  const std::uint64_t simulation_bytes_;
  const MemoryLease scene_memory_;
  MemoryLease simulations_memory_;  ///< of the idle ones and of those that are leased
  std::vector<Field> fields_;
  std::size_t block_count_ = 0;
  std::size_t saved_size_ = 0;
  double step_cost_ = 1;
  double step_work_ = 0;
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
  /// The states of callers that rest, by step.
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

  /// The session, for whoever will use it again later; it may expire meanwhile.
  const std::shared_ptr<Session>& session() const { return session_; }
  Session* operator->() const { return session_.get(); }
  Session& operator*() const { return *session_; }

 private:
  std::shared_ptr<Session> session_;
};

}  // namespace stiefel::server
