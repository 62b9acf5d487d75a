#pragma once

#include <string>

#include "stiefel/scene.h"

namespace stiefel::testing {

/// Returns (tanh s, sech s; sech s, −tanh s). For D = diag(2, 1) the motion that starts there is at
/// two_by_two(s + 2t) at time t.
RowMatrix two_by_two(double s);

/// Returns a scene of `brockett` that starts at two_by_two(s). An empty method leaves it out.
SceneDescription toy_scene(const std::string& method = "", double s = -1, double step = 0.05);

}  // namespace stiefel::testing
