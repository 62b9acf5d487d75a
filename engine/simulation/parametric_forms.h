#pragma once

#include "engine/simulation/stacked_readout.h"
#include "engine/simulation/system_entry.h"

namespace stiefel {

/// What parametric_rigid_body and parametric_moser_veselov have in common; [RB] (8.4)–(8.6),
/// (8.10). `momentum` is the formula of the field M.
SystemInfo parametric_info(std::string_view momentum);

/// Λ, Q and P invertible with M = M_μ − μΛ² skew, `parameter`. `h`: what M stands multiplied by.
void check_parametric(SceneDraft& draft, double h);

/// Q over P, and M = (M_μ − μΛ²)/h with the invariants.
StackedReadout parametric_readout(const Scene& scene, double h);

}  // namespace stiefel
