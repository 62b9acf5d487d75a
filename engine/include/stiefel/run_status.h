#pragma once

#include <cstdint>
#include <optional>

namespace stiefel {

/// How a run ended. After every outcome but `reached` the simulation is at the last good state.
enum class Outcome { reached, left_domain, solver_stalled, not_finite, cancelled };

struct RunStatus {
  Outcome outcome = Outcome::reached;
  /// left_domain: the largest |h| with which the next step of the scene, all of its substeps of h,
  /// has a solution from the last good state, to 1e-3 (to 5 % where shorter steps have none); empty
  /// where none was found.
  std::optional<double> largest_step;
  /// In an ensemble: the member that stopped first.
  std::optional<std::int64_t> member = {};

  bool reached() const { return outcome == Outcome::reached; }
};

}  // namespace stiefel
