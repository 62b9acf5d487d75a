#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

namespace stiefel::server {

/// What Simulation::save gave at a step.
using Saved = std::shared_ptr<const std::vector<double>>;

/// The states a session can start again from: step 0, the multiples of a spacing that doubles when
/// there would be too many of them, and at most two states that came from elsewhere. Not
/// thread-safe.
class Checkpoints {
 public:
  static constexpr std::size_t max_count = 64;
  static constexpr std::size_t max_bytes = std::size_t{64} << 20;

  explicit Checkpoints(std::int64_t spacing) : spacing_(spacing) {}

  /// Whether `put` would take a state at this step.
  bool wants(std::int64_t step) const { return step % spacing_ == 0 && !saved_.contains(step); }
  void put(std::int64_t step, Saved saved);
  /// Takes a state at any step. Of those adopted the earliest and the newest stay, where they have
  /// no place together the later one.
  void adopt(std::int64_t step, Saved saved);

  struct Nearest {
    std::int64_t step;
    Saved saved;
  };
  /// The last one at or before `step`; where there is none, step 0 without a state: that of the
  /// scene.
  Nearest nearest(std::int64_t step) const;

  /// The first index after `step` where a state is worth keeping.
  std::int64_t next(std::int64_t step) const { return (step / spacing_ + 1) * spacing_; }
  std::int64_t spacing() const { return spacing_; }
  std::vector<std::int64_t> steps() const;

  /// How many can be computed again: all but step 0 and the adopted ones.
  std::size_t computed() const;
  /// Drops them.
  void shed();

 private:
  void thin();
  bool is_adopted(std::int64_t step) const;
  /// No longer kept for itself.
  void release(std::size_t adopted);
  template <class Drop>
  void drop_if(Drop drop);

  std::int64_t spacing_;
  std::vector<std::int64_t> adopted_;  // at most two steps, the earlier first
  std::size_t bytes_ = 0;
  std::map<std::int64_t, Saved> saved_;
};

}  // namespace stiefel::server
