#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

namespace stiefel::server {

/// A state as Simulation::save wrote it.
using Saved = std::shared_ptr<const std::vector<double>>;

/// The states from which a session can start again: step 0, the multiples of a spacing that doubles
/// when there are too many, and at most two adopted states, which come from a client's checkpoint
/// or from the store. Not thread-safe.
class Checkpoints {
 public:
  static constexpr std::size_t max_count = 64;
  static constexpr std::size_t max_bytes = std::size_t{64} << 20;

  explicit Checkpoints(std::int64_t spacing) : spacing_(spacing) {}

  /// Whether `put` would take a state at this step.
  bool wants(std::int64_t step) const { return step % spacing_ == 0 && !saved_.contains(step); }
  void put(std::int64_t step, Saved saved);
  /// Takes a state at any step. Of the adopted states keeps the one at the smallest step and the
  /// newest; if the two do not fit together, only the one at the larger step. `evict` drops it
  /// unless it is `lasting`.
  void adopt(std::int64_t step, Saved saved, bool lasting = true);

  struct Nearest {
    std::int64_t step;
    Saved saved;
  };
  /// Returns the last state at or before `step`; if there is none, step 0 without a state, which
  /// stands for the scene's initial state.
  Nearest nearest(std::int64_t step) const;

  std::int64_t spacing() const { return spacing_; }
  std::vector<std::int64_t> steps() const {
    std::vector<std::int64_t> steps;
    for (const auto& [step, saved] : saved_) steps.push_back(step);
    return steps;
  }

  /// The number of states that `evict` drops: all but step 0 and the lasting adopted ones.
  std::size_t evictable() const {
    return computed() +
           static_cast<std::size_t>(std::ranges::count(adopted_, false, &Adopted::lasting));
  }
  void evict();

 private:
  struct Adopted {
    std::int64_t step;
    bool lasting;
  };

  void thin();
  /// The number of states that are neither at step 0 nor adopted.
  std::size_t computed() const;
  bool is_adopted(std::int64_t step) const {
    return std::ranges::find(adopted_, step, &Adopted::step) != adopted_.end();
  }
  /// Drops the adopted state with that index in `adopted_`; keeps it as a computed one if its step
  /// is a multiple of the spacing.
  void drop_adopted(std::size_t index);
  template <class Drop>
  void drop_if(Drop drop);

  std::int64_t spacing_;
  std::vector<Adopted> adopted_;  // at most two, the earlier first
  std::size_t bytes_ = 0;
  std::map<std::int64_t, Saved> saved_;
};

}  // namespace stiefel::server
