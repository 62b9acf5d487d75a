#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/scheduling/memory_budget.h"
#include "server/sessions/checkpoints/checkpoints.h"
#include "server/sessions/identity.h"
#include "stiefel/price.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"

namespace stiefel::server {

/// A field that is not finite at step 0.
struct Overflow {
  std::string field;
  double value;
};

/// Frees the memory of a simulation, and then what was reserved for it.
struct FreeSimulation {
  MemoryLease reserved = {};
  void operator()(Simulation* simulation) const { delete simulation; }
};
/// A simulation that takes its bytes from a budget.
using SimulationPtr = std::unique_ptr<Simulation, FreeSimulation>;

/// A pure function from step index to state: the scene and a cache of states to start from. No lock
/// is held during a computation: a caller acquires a Simulation, advances it and releases it, so
/// several callers can use one session at once. Thread-safe.
class Session {
 public:
  static constexpr std::int64_t max_step = std::int64_t{1} << 53;

  /// `memory` must outlive the session. Throws MemoryExhausted when the scene, its state and its
  /// simulation do not fit into `memory`, as does `acquire`.
  explicit Session(Scene scene, MemoryBudget& memory = MemoryBudget::unlimited());

  const Scene& scene() const { return scene_; }
  /// SHA-256 of the resolved scene, 32 bytes: equal exactly for equal scenes.
  const std::string& identity() const { return identity_; }
  /// Simulation::fields.
  const std::vector<Field>& fields() const { return outline_.fields; }
  /// The indices of the fields that are reported where none are named.
  const std::vector<std::size_t>& default_fields() const { return default_fields_; }
  std::size_t saved_size() const { return outline_.saved_size; }
  double step_cost() const { return outline_.step_cost; }
  /// stiefel::warnings of the scene.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// Whether every state is computed directly from that at step 0, however far away it is.
  bool direct() const { return outline_.direct; }
  bool members_are_numbers() const { return outline_.numbers; }
  /// The predicted work of a step in instructions. A `direct` session takes as much to any state.
  double step_work() const { return step_work_; }
  /// A field that is not finite at step 0, where 1/λ or λ_i + λ_j overflows.
  const std::optional<Overflow>& overflow() const { return overflow_; }

  /// Returns a simulation for the caller alone: in the state `saved` of that step or, without one,
  /// at the nearest state at or before `step`.
  SimulationPtr acquire(std::int64_t step, const Saved& saved = nullptr);
  /// Keeps the simulation for the next caller. One that an exception left between two states must
  /// be destroyed instead.
  void release(SimulationPtr simulation) noexcept;
  /// Returns a copy of the simulation's state. Callers at the same step share one copy. Null when
  /// there is no memory for it.
  Saved snapshot(const Simulation& simulation);

  /// The predicted bytes of the scene, and 8 KiB for the session itself.
  std::uint64_t scene_bytes() const { return scene_memory_.bytes(); }
  /// The predicted bytes of one simulation of the scene.
  std::uint64_t simulation_bytes() const { return simulation_bytes_; }
  /// The bytes that `evict` would give back.
  std::uint64_t cached_bytes() const;
  /// Drops what can be computed again: idle simulations, and the checkpoints that are neither at
  /// step 0 nor a client's.
  void evict();

  /// Returns the first step after `step` where `put_checkpoint` would keep the state.
  std::int64_t next_checkpoint(std::int64_t step) const {
    const std::int64_t spacing = spacing_.load(std::memory_order_relaxed);
    return (step / spacing + 1) * spacing;
  }
  /// Keeps the state if its step is one of the fixed indices and there is memory for it.
  void put_checkpoint(const Simulation& simulation);
  /// Keeps a state of `saved_size()` numbers: that of a client's checkpoint for good (throws
  /// MemoryExhausted), that of the store until `evict`, if there is memory for it.
  void restore_checkpoint(std::int64_t step, std::vector<double> saved, bool of_client = true);

  /// Returns the steps of the cached states in increasing order, from 0.
  std::vector<std::int64_t> cached_steps() const;
  /// The step at which the last call left its simulation.
  std::int64_t cursor() const { return cursor_.load(std::memory_order_relaxed); }

  /// Returns the last cached state, once after each new one; nothing in between and at step 0.
  std::optional<Checkpoints::Nearest> take_new_state();
  bool has_new_state() const { return has_new_state_.load(std::memory_order_relaxed); }

 private:
  SimulationPtr make();
  /// Takes one out of `idle_`. Requires the lock.
  SimulationPtr take(SimulationPtr& one);
  /// Sets the work of a step from one of the `members`, or from the scene itself:
  /// `rate` is the largest ‖Ω‖ at the start.
  void set_work(const Scene& one, std::size_t members, double rate);
  /// Steps of the map between two states.
  double map_steps() const { return direct() ? 1 : scene_.substeps(); }

  MemoryBudget& memory_;
  const Scene scene_;
  const std::string identity_;
  const std::uint64_t simulation_bytes_;
  const MemoryLease scene_memory_;
  Outline outline_;
  std::vector<std::size_t> default_fields_;
  double step_work_ = 0;
  const std::vector<std::string> warnings_;
  std::optional<Overflow> overflow_;

  std::atomic<std::int64_t> cursor_ = 0;
  std::atomic<std::int64_t> spacing_ = 1;
  std::atomic<bool> has_new_state_ = false;  ///< that `take_new_state` has not returned

  mutable std::mutex mutex_;  // guards all of these
  Checkpoints checkpoints_;
  std::array<SimulationPtr, 2> idle_;  ///< the last used at the back
  /// Snapshots by step.
  std::map<std::int64_t, std::weak_ptr<const std::vector<double>>> snapshots_;
};

}  // namespace stiefel::server
