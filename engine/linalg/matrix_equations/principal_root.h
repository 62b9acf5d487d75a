#pragma once

#include "engine/linalg/arithmetic/scalar.h"

namespace stiefel {

/// A^{1/2} with its spectrum in Re > 0, of a real N × N matrix that has no eigenvalue on (−∞, 0]: X
/// ← ½(X + Y⁻¹), Y ← ½(Y + X⁻¹) from X = A, Y = I (Denman and Beavers 1976); quadratic convergence.
Matrix<double> principal_root(const Matrix<double>& A);

}  // namespace stiefel
