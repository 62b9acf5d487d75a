#pragma once

#include <optional>

#include "engine/numbers/scalar.h"

namespace stiefel::testing {

/// Reference solver: returns the U with UΛ − ΛUᵀ = K, for K = hM skew and every λ_i > 0, by [RB]
/// (7.13), (7.14),
///
///     U = (S + K/2) Λ⁻¹,   S² + [S, K/2] = Λ² + K²/4,
///
/// where [I; S] spans the invariant subspace with Re > 0 of [[K/2, I], [K²/4 + Λ², K/2]], from
/// LAPACK's ordered Schur form. It takes about 200 N³ operations; ‖UᵀU − I‖ is 5e-12 at Λ = 1:10³.
/// Returns nothing when an eigenvalue is imaginary: then there is no solution.
std::optional<Matrix<double>> J_D_inverse_schur(const Vector<double>& lambda,
                                                const Matrix<double>& K);

}  // namespace stiefel::testing
