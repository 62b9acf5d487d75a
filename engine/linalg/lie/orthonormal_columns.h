#pragma once

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Returns the first k ≤ N columns of the orthogonal N × N factor of the QR decomposition of A,
/// which has N rows, by Householder's reflections: the columns of A made orthonormal, then columns
/// that complete them to a basis.
template <class Scalar>
Matrix<Scalar> orthonormal_columns(const Matrix<Scalar>& A, Eigen::Index k);

// Compiled once, in orthonormal_columns.cc.
extern template Matrix<double> orthonormal_columns(const Matrix<double>& A, Eigen::Index k);
extern template Matrix<long double> orthonormal_columns(const Matrix<long double>& A,
                                                        Eigen::Index k);

}  // namespace stiefel
