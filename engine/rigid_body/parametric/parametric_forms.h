#pragma once

#include "engine/catalogue/representation.h"
#include "engine/catalogue/series_start.h"
#include "engine/catalogue/system_entry.h"
#include "engine/stepping/stacked_observables.h"

namespace stiefel {

extern const SeriesEquations parametric_equations;

/// Returns the common data of parametric_rigid_body and parametric_moser_veselov; [RB] (8.4)–(8.6),
/// (8.10). `momentum` is the formula of the field M, which also defines epsilon.
SystemInfo parametric_info(std::string_view momentum);

/// Checks Λ; Q and P invertible with M = (Q⁻¹P − P⁻¹Q)/ε − (μ/h)Λ² skew; `parameter`, which is μ, 0
/// if absent; and `epsilon`, which if absent is h, as in the paper's own variables. h = 1 for the
/// flow.
void check_parametric(SceneDraft& draft, double h);

/// Read and write (Q, P) with parameter, [RB] (8.5), (8.10).
WithinDomain<Phase> read_parametric(const Scene& scene, Margins& margins);
WithinDomain<Expression> write_parametric(double h, const Phase& x, const ConversionTarget& target,
                                          Margins& margins);

/// Returns the observables of Q over P: the blocks, M and epsilon, and the invariants.
StackedObservables parametric_observables(const Scene& scene, double h);

}  // namespace stiefel
