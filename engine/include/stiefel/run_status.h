#pragma once

#include <cstdint>
#include <optional>

namespace stiefel {

/// How a run ended. Anything but `reached` leaves the last good state in place.
enum class Outcome { reached, left_domain, solver_stalled, not_finite, cancelled };

struct RunStatus {
  Outcome outcome = Outcome::reached;
  /// left_domain: the largest |h| that has a solution from the last good state, to 1e-3.
  std::optional<double> largest_step;
  /// Of an ensemble: the member that ended it.
  std::optional<std::int64_t> member = {};

  bool reached() const { return outcome == Outcome::reached; }
};

}  // namespace stiefel
