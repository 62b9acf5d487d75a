#pragma once

#include <string>

#include "stiefel/scene.h"

namespace stiefel::testing {

/// Adds the system `brockett` and the method `heun` to the catalogue, and
/// `brockett_without_reference`. Once, before anything is asked of the catalogue.
void register_toys();

/// (tanh s, sech s; sech s, -tanh s). For D = diag(2, 1) the motion from it is at time t that of
/// s + 2t.
RowMatrix two_by_two(double s);

/// A scene of the system from two_by_two(s), with a method or without.
SceneDescription toy_scene(const std::string& method = "", double s = -1, double step = 0.05);

}  // namespace stiefel::testing
