#pragma once

#include <optional>
#include <string>

namespace stiefel::testing {

/// An estimate of the error on a seeded random scene beside the true one.
struct ErrorOutcome {
  std::string scene;      ///< what it was
  std::string reference;  ///< what the estimate was made with
  std::string missing;    ///< or why there is none
  /// Estimated over true, each where the true one is above 1e-14 and an estimate was told.
  std::optional<double> attitude, momentum;
};

/// A random scene of any continuous system with any of its methods, orders, arithmetics and
/// scalars, run over up to some tens of radians either way. The true error is that against
/// Boost.odeint's Bulirsch–Stoer in extended precision, in the scene's own variables.
ErrorOutcome survey_error(unsigned seed);

/// Of many seeds: no estimate is below half of the true error, and at most 5 % above ten times.
void expect_estimates(unsigned first, unsigned count);

}  // namespace stiefel::testing
