#pragma once

#include <optional>
#include <string>

namespace stiefel::testing {

/// The estimated error of a seeded random scene, compared with the true error.
struct ErrorOutcome {
  std::string scene;      ///< the scene in words
  std::string reference;  ///< the reference of the estimate
  std::string missing;    ///< why there is no estimate; empty if there is one
  /// Estimated error divided by true error. Empty without an estimate, and where the true error is
  /// below 1e-14 or not known to a tenth.
  std::optional<double> attitude, momentum;
};

/// Runs a random scene of any continuous system with any of its methods, orders, arithmetics and
/// scalars, over up to some tens of radians in either direction. The true error is measured against
/// Boost.odeint's Bulirsch–Stoer method in extended precision, in the scene's own variables.
ErrorOutcome survey_error(unsigned seed);

/// Expects over many seeds that no estimate is below half of the true error, and that at most 5 %
/// are above ten times the true error.
void expect_estimates(unsigned first, unsigned count);

}  // namespace stiefel::testing
