#pragma once

#include <optional>

#include "engine/numbers/scalar.h"

namespace stiefel::testing {

/// Returns the X for which [I; X] spans the invariant subspace of H, 2n × 2n, of the eigenvalues in
/// Re > 0, from LAPACK's ordered Schur form. Returns nothing where an eigenvalue is imaginary, or
/// where they are not n.
std::optional<Matrix<double>> right_half_subspace(Matrix<double> H);

}  // namespace stiefel::testing
