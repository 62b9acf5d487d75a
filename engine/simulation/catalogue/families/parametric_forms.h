#pragma once

#include "engine/simulation/catalogue/system_entry.h"
#include "engine/simulation/stepping/stacked_observables.h"

namespace stiefel {

/// The common data of parametric_rigid_body and parametric_moser_veselov; [RB] (8.4)–(8.6),
/// (8.10). `momentum` is the formula of the field M, which
/// says what epsilon is too.
SystemInfo parametric_info(std::string_view momentum);

/// Λ; Q and P invertible with M = (Q⁻¹P − P⁻¹Q)/ε − (μ/h)Λ² skew; `parameter` μ, 0 if absent;
/// `epsilon`, that of the paper's own variables, h, if absent. h = 1 for the flow.
void check_parametric(SceneDraft& draft, double h);

/// Q over P, M and epsilon, with the invariants.
StackedObservables parametric_observables(const Scene& scene, double h);

}  // namespace stiefel
