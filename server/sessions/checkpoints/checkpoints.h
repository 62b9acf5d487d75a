#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

namespace stiefel::server {

/// A state as Simulation::save wrote it.
using Saved = std::shared_ptr<const std::vector<double>>;

/// The states from which a session can start again: step 0, the multiples of a spacing that doubles
/// when there are too many, and at most two restored states, which come from a client's checkpoint
/// or from the store. Not thread-safe.
class Checkpoints {
 public:
  static constexpr std::size_t max_count = 64;
  static constexpr std::size_t max_bytes = std::size_t{64} << 20;

  explicit Checkpoints(std::int64_t spacing) : spacing_(spacing) {}

  /// Whether `put` would take a state at this step.
  bool wants(std::int64_t step) const { return step % spacing_ == 0 && !saved_.contains(step); }
  void put(std::int64_t step, Saved saved);
  /// Takes a state at any step. Of the restored states keeps the one at the smallest step and the
  /// newest; if the two do not fit together, only the one at the larger step. `evict` drops it
  /// unless it is `pinned`.
  void restore(std::int64_t step, Saved saved, bool pinned = true);

  struct Nearest {
    std::int64_t step;
    Saved saved;
  };
  /// Returns the last state at or before `step`; if there is none, step 0 without a state, which
  /// stands for the scene's initial state.
  Nearest nearest(std::int64_t step) const;

  std::int64_t spacing() const { return spacing_; }
  std::vector<std::int64_t> steps() const;

  /// The number of states that `evict` drops: all but step 0 and the pinned ones.
  std::size_t evictable() const;
  void evict();

 private:
  struct State {
    Saved saved;
    bool restored = false, pinned = false;
  };

  /// Doubles the spacing until the states fit; drops the first of two restored ones at last.
  void thin();
  bool fits() const;
  /// Makes a restored state a computed one, which stays if its step is a multiple of the spacing.
  void release(std::int64_t step);
  static bool is_evictable(const std::pair<const std::int64_t, State>& one) {
    return one.first != 0 && !one.second.pinned;
  }

  std::int64_t spacing_;
  std::map<std::int64_t, State> saved_;
};

}  // namespace stiefel::server
