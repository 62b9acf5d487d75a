#pragma once

#include <complex>

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Returns the eigenvalues of a real N × N matrix.
Vector<std::complex<double>> spectrum(const Matrix<double>& A);

}  // namespace stiefel
