#pragma once

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Replaces the lower triangle of a symmetric A, of which it reads nothing else, by that of L, A =
/// LLᵀ. Returns false where A is not positive. Checks for a stop request (stiefel/stop.h) before
/// each block of at most 128 columns. The operations and their order are those of Eigen's LLT, so
/// the bits are too.
bool factor_positive(Matrix<double>& A);

/// Announces to `stop_point` and computes L⁻¹B, L the lower triangle of a matrix.
void divide_by_lower(const Matrix<double>& L, Matrix<double>& B);

}  // namespace stiefel
