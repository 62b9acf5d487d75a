#pragma once

#include <optional>
#include <string_view>

#include "engine/simulation/catalogue/system_entry.h"
#include "stiefel/scene.h"

namespace stiefel {

/// Work of one step of the map that a scene asks for, in instructions as callgrind counts them at
/// h‖Ω‖ = 0.1, from a table that tests/bench/weights.py measures in several sizes: between two of
/// them a power law, beyond them the last one times f(n, N) over its f,
///
///     f(n, N) = n²N + n³ + 8nN.
///
/// Equal on every CPU for one build, so that every machine chooses the same method. Work is
/// `Simulation::map_steps()` times this.
double step_weight(const Scene& scene);

/// The price of one step at that h‖Ω‖ > 0 (`Simulation::rate` times the step of the map): of an
/// explicit method `step_weight`, of one that iterates times a factor of the table, which has it at
/// some h‖Ω‖, the power law between them, and the nearest one's beyond them.
double step_price(const Scene& scene, double h_omega);
/// The price of one step of as many bodies like this one as a register of AVX2 holds
/// (`pack_lanes`), side by side; nothing where the table has none: for bodies that cannot be
/// packed.
std::optional<double> pack_price(const Scene& one, double h_omega);
/// 4 numbers in double precision, 8 in single.
int pack_lanes(const Scene& one);
/// Whether `step_price` depends on h‖Ω‖.
bool price_depends_on_rate(const Scene& scene);

/// The rows of the first block of the scene's state, or N where it goes without, and N; what n and
/// N are above unless the system says otherwise (SystemEntry::size).
FrameSize frame_size(const Scene& scene);

/// Whether the table has it. The weight of what it has not is estimated: five instructions for each
/// nanosecond that the system's `make` says a step takes. warnings.cc says so.
bool is_weighed(const Scene& scene);
bool is_weighed(std::string_view system, std::string_view method, int order,
                std::string_view arithmetic, std::string_view scalar);

}  // namespace stiefel
