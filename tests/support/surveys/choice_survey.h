#pragma once

#include <string>

namespace stiefel::testing {

/// The method that is chosen for the tolerance of a seeded random scene, and how good it is.
struct ChoiceOutcome {
  std::string scene;   ///< the scene in words
  std::string chosen;  ///< the reason of the choice, or why there was none
  bool made = false;   ///< whether a method was chosen
  double error = 0;    ///< error of the chosen method against the exact motion, over the tolerance
  double cost = 0;     ///< work of the chosen method over that of the cheapest sufficient one; or 0
};

/// Makes a random scene of rigid_body (N = 3 … 6) or stiefel with a random tolerance, 1e-3 … 1e-10,
/// and a random horizon, lets the engine choose a method, and judges it by a solution that the
/// choice does not use.
ChoiceOutcome survey_choice(unsigned seed);

}  // namespace stiefel::testing
