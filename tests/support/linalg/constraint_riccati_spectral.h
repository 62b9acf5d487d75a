#pragma once

#include <optional>

#include "engine/numbers/scalar.h"

namespace stiefel::testing {

/// Reference solver: returns the Y with E + YA + AᵀY + YPY = 0 and spec(A + PY) in Re > 0. [I; Y]
/// spans the eigenvectors of [[A, P], [−E, −Aᵀ]] whose eigenvalues have Re > 0. The spectrum is
/// symmetric about the imaginary axis. Returns nothing when an eigenvalue lies on that axis: then
/// there is no solution.
std::optional<Matrix<double>> constraint_riccati_spectral(const Matrix<double>& A,
                                                          const Matrix<double>& P,
                                                          const Matrix<double>& E);

}  // namespace stiefel::testing
