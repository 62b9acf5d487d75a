#pragma once

#include <cstddef>

#include "stiefel/scene.h"

namespace stiefel {

/// Returns the bytes that `make_simulation(scene)` and its first steps allocate, predicted from a
/// table of how many matrices of the scene's size each method keeps; for an ensemble the sum over
/// its members. This is an upper bound except for small objects:
/// tests/engine/programs/workspace_test.cc counts them.
std::size_t simulation_bytes(const Scene& scene);

/// Returns the bytes that the largest simulation of a scene with n x N blocks takes, whatever its
/// method.
std::size_t largest_simulation_bytes(double n, double N);

/// Returns the bytes of a resolved scene with this description, including its members and the
/// description itself.
std::size_t scene_bytes(const SceneDescription& description);

/// Returns the bytes of the arrays of a description.
std::size_t array_bytes(const SceneDescription& description);

}  // namespace stiefel
