#pragma once

#include <optional>
#include <string>

#include "stiefel/price.h"

namespace stiefel {

/// Returns the price of one step of as many bodies like this one, side by side, as a register of
/// AVX2 holds (`pack_lanes`); nullopt where the table has no entry, which is so for bodies that
/// cannot be packed.
std::optional<double> pack_price(const Scene& one, double h_omega);
/// Returns 4 in double precision, 8 in single.
int pack_lanes(const Scene& one);

/// Returns a warning where the table has no entry for a scene that has a method; else nullopt.
std::optional<std::string> estimate_warning(const Scene& scene);

/// Estimates the instructions of a step of a scene that has no entry in the table: those of
/// a system of its size, times the relative work of its method.
///
/// The relative work is the work of the method divided by the geometric mean of the work of all
/// methods of the scene's system, as the other systems of the table have them at the size of the
/// scene. It is the geometric mean over the systems that have all these methods; methods that no
/// system of the table has are left out, and have the relative work 1.
double estimated_weight(const Scene& scene, const FrameSize& size);

}  // namespace stiefel
