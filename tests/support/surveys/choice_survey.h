#pragma once

#include <string>

namespace stiefel::testing {

/// The choice by tolerance on a seeded random scene.
struct ChoiceOutcome {
  std::string scene;   ///< the scene in words
  std::string chosen;  ///< the resolved scene's `choice`, or why there was none
  bool made = false;
  double error = 0;  ///< of the chosen, against the exact motion, over the tolerance
  double cost = 0;   ///< over that of the best entry of the exhaustive table; 0 without one
};

/// A random scene of rigid_body (N = 3 … 6) or stiefel with a random tolerance, 1e-3 … 1e-10, and
/// horizon; its choice, and both judged by a solution that the choice does not see.
ChoiceOutcome survey_choice(unsigned seed);

}  // namespace stiefel::testing
