#pragma once

#include "engine/simulation/scene.h"

namespace stiefel {

/// Work of one step of the map that a scene asks for, in instructions as callgrind counts them at
/// h‖Ω‖ = 0.1, from a table that tests/bench/weights.py measures: for n × N
///
///     a + b nN + c (n²N + n³),   and at n = N = 3 a number of its own.
///
/// The same for every CPU of a build, so that what is decided by it is decided alike everywhere.
/// Work is `Simulation::map_steps()` times this.
double step_weight(const Scene& scene);

/// Whether the table has it; for what is not in it yet the weight is a rough guess.
bool is_weighed(std::string_view system, std::string_view method, int order,
                std::string_view arithmetic);

}  // namespace stiefel
