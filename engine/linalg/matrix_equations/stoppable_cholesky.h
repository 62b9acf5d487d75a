#pragma once

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Replaces the lower triangle of a symmetric m × m matrix A, of which it reads nothing else, by
/// that of L, A = LLᵀ. Returns false, with A lost, where A is not positive definite. Checks for a
/// stop request (stiefel/stop.h) before each block of at most 128 columns. The operations and their
/// order are those of Eigen's LLT, so the bits are too.
bool factor_positive(Matrix<double>& A);

/// Replaces B, m × k, by L⁻¹B, L the lower triangle of an m × m matrix. Checks for a stop request
/// before each 32 columns of B.
void divide_by_lower(const Matrix<double>& L, Matrix<double>& B);

}  // namespace stiefel
