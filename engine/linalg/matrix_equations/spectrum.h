#pragma once

#include <complex>

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Returns the eigenvalues of a real N × N matrix.
Vector<std::complex<double>> spectrum(const Matrix<double>& A);

/// Returns A^{1/2} with its spectrum in Re > 0, for a real N × N matrix A without eigenvalues on
/// (−∞, 0]. Iterates X ← ½(X + Y⁻¹), Y ← ½(Y + X⁻¹) from X = A, Y = I (Denman and Beavers 1976);
/// convergence is quadratic.
Matrix<double> principal_root(const Matrix<double>& A);

}  // namespace stiefel
