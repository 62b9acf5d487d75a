#pragma once

#include <string>

#include "stiefel/scene.h"

namespace stiefel::testing {

/// A seeded rigid body: Λ spread over 1 : spread, a random frame with det +1 and a full random M,
/// with ‖Ω‖ = 1, so that h‖Ω‖ is the step.
struct RandomBody {
  Eigen::VectorXd lambda;
  Eigen::MatrixXd Q, M;
  RandomBody(int N, unsigned seed, double spread = 4);
};

/// The body of `RandomBody` as a description; an empty method makes it a moser_veselov scene.
SceneDescription description(const RandomBody& body, double step, const std::string& method,
                             const std::string& arithmetic = "");

/// The body of `RandomBody` as a resolved scene; throws std::bad_expected_access when refused.
Scene random_scene(int N, unsigned seed, double step, const std::string& method,
                   const std::string& arithmetic = "");

}  // namespace stiefel::testing
