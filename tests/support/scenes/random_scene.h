#pragma once

#include <string>

#include "stiefel/scene.h"

namespace stiefel::testing {

/// A seeded rigid body: Λ between 1 and `spread`, a random frame with determinant +1, and a full
/// random M with ‖Ω‖ = 1, so that h‖Ω‖ is the step.
struct RandomBody {
  Eigen::VectorXd lambda;
  Eigen::MatrixXd Q, M;
  RandomBody(int N, unsigned seed, double spread = 4);
};

/// Returns the description of a body's scene. An empty method makes it a moser_veselov scene.
SceneDescription description(const RandomBody& body, double step, const std::string& method,
                             const std::string& arithmetic = "");

/// Returns the resolved scene of a `RandomBody`. Throws std::bad_expected_access if it is refused.
Scene random_scene(int N, unsigned seed, double step, const std::string& method,
                   const std::string& arithmetic = "");

}  // namespace stiefel::testing
