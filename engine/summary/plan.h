#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <span>
#include <vector>

#include "engine/summary/readings.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"
#include "stiefel/summary.h"

namespace stiefel {

/// A checked description, with what all members derive from it.
struct Plan {
  /// The position of a time of the description among the steps.
  struct Time {
    std::int64_t before;   ///< the last step at or before the time
    std::int64_t arrival;  ///< the first step at or after the time
    double fraction;       ///< the time is at step before + fraction, 0 ≤ fraction < 1
  };
  /// What a quantity reads of one member.
  struct Read {
    std::size_t size = 0;  ///< number of values; two for each element of a complex field
    std::vector<std::size_t> shape = {};
    bool complex = false;
    bool on_the_way = false;  ///< read at every sample, not only at the last one
    bool drift = false;
    std::size_t first = 0;  ///< where the values stand in Member::last
    /// Reads the one scene, or every body of FlatBodies; there null for what depends on the start.
    std::shared_ptr<Reading> common = nullptr;
  };

  SummaryDescription what;
  bool discrete = false;
  double step_size = 0;  ///< Scene::step
  std::vector<Time> times;
  std::vector<Read> reads;
  std::vector<std::size_t> fields;  ///< indices of the fields that are written at times and events
  std::size_t state_size = 0;       ///< number of their values for one member
  std::size_t last_size = 0;        ///< number of the values of all quantities
  bool reads_on_the_way = false;

  /// Returns a quantity's part of Member::last.
  template <class Numbers>
  auto last(Numbers& all, std::size_t quantity) const {
    return std::span(all).subspan(reads[quantity].first, reads[quantity].size);
  }
  std::int64_t samples() const {
    const std::int64_t steps = what.to - what.from;
    return steps / what.every + 1 + (steps % what.every > 0);
  }
  /// Whether a step is from + i·every, i ≥ 0.
  bool on_grid(std::int64_t step) const {
    return step >= what.from && (step - what.from) % what.every == 0;
  }
  /// Returns the first step of the grid after `step`, or `to`.
  std::int64_t next_sample(std::int64_t step) const {
    if (step < what.from) return what.from;
    const std::int64_t done = (step - what.from) / what.every * what.every;
    return what.to - what.from - done > what.every ? what.from + done + what.every : what.to;
  }
};

/// Checks a description against `start`, the simulation of the scene (of an ensemble: of its first
/// member) at step 0.
std::expected<Plan, Violations> make_plan(const Scene& scene, const Simulation& start,
                                          SummaryDescription what);

}  // namespace stiefel
