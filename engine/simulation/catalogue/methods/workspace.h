#pragma once

#include <cstddef>

#include "stiefel/scene.h"

namespace stiefel {

/// Bytes that `make_simulation(scene)` and its first steps allocate, predicted from a table of how
/// many matrices of the scene's size each method keeps; of an ensemble the sum over its members. An
/// upper bound but for small objects: tests/engine/programs/workspace_test.cc counts them.
std::size_t simulation_bytes(const Scene& scene);

/// Bytes that the largest simulation of a scene with n x N blocks takes, whatever its method.
std::size_t largest_simulation_bytes(double n, double N);

/// Bytes of a resolved scene of that description, members and the description itself included.
std::size_t scene_bytes(const SceneDescription& description);

/// Bytes of the arrays of a description.
std::size_t array_bytes(const SceneDescription& description);

}  // namespace stiefel
