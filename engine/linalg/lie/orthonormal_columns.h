#pragma once

#include "engine/linalg/arithmetic/scalar.h"

namespace stiefel {

/// The first k columns, k ≤ N, of the orthogonal N × N factor of the QR factors of A, N rows, by
/// Householder's reflections: those of A made orthonormal, and after them what completes them.
template <class Scalar>
Matrix<Scalar> orthonormal_columns(const Matrix<Scalar>& A, Eigen::Index k);

// Compiled once, in orthonormal_columns.cc.
extern template Matrix<double> orthonormal_columns(const Matrix<double>& A, Eigen::Index k);
extern template Matrix<long double> orthonormal_columns(const Matrix<long double>& A,
                                                        Eigen::Index k);

}  // namespace stiefel
