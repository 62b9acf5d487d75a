#pragma once

#include <optional>
#include <string>

namespace stiefel::testing {

/// An estimate of the error on a seeded random scene beside the true one.
struct ErrorOutcome {
  std::string scene;      ///< the scene in words
  std::string reference;  ///< the reference of the estimate
  std::string missing;    ///< or why there is no estimate
  /// Estimated over true error, where there is an estimate and the true error is known to a tenth
  /// and above 1e-14.
  std::optional<double> attitude, momentum;
};

/// A random scene of any continuous system with any of its methods, orders, arithmetics and
/// scalars, run over up to some tens of radians either way. The true error is that against
/// Boost.odeint's Bulirsch–Stoer in extended precision, in the scene's own variables.
ErrorOutcome survey_error(unsigned seed);

/// Over many seeds: no estimate is below half of the true error, and at most 5 % are above ten
/// times the true error.
void expect_estimates(unsigned first, unsigned count);

}  // namespace stiefel::testing
