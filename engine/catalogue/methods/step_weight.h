#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "engine/catalogue/system_entry.h"
#include "stiefel/scene.h"

namespace stiefel {

/// Returns the work of one step of the map of a scene, in instructions as callgrind counts them at
/// h‖Ω‖ = 0.1, from a table that tests/bench/weights.py measures in several sizes (weight_table.h).
/// The table is the same on every CPU for one build, so that every machine chooses the same method.
/// The work of a run is `Simulation::map_steps()` times this number.
double step_weight(const Scene& scene);

/// Returns the price of one step at this h‖Ω‖ > 0 (`Simulation::rate` times the step of the map).
/// For an explicit method it is `step_weight`; for one that iterates, `step_weight` times a factor
/// that the table has at some h‖Ω‖: between them a power law, beyond them the nearest.
double step_price(const Scene& scene, double h_omega);
/// Returns the price of one step of as many bodies like this one, side by side, as a register of
/// AVX2 holds (`pack_lanes`); nullopt where the table has no entry, which is so for bodies that
/// cannot be packed.
std::optional<double> pack_price(const Scene& one, double h_omega);
/// Returns 4 in double precision, 8 in single.
int pack_lanes(const Scene& one);
/// Whether `step_price` depends on h‖Ω‖.
bool price_depends_on_rate(const Scene& scene);

/// Returns the size of a scene by which `step_weight` is tabulated: n is the number of rows of the
/// first block of its state, or N where the scene has none, unless the system defines its own size
/// (SystemEntry::size).
FrameSize frame_size(const Scene& scene);

/// Whether the table has an entry. Without one the weight is estimated (weight_estimate.h).
bool is_weighed(const Scene& scene);
bool is_weighed(std::string_view system, std::string_view method, int order,
                std::string_view arithmetic, std::string_view scalar);

/// Returns a warning where the table has no entry for a scene that has a method; else nullopt.
std::optional<std::string> estimate_warning(const Scene& scene);

}  // namespace stiefel
