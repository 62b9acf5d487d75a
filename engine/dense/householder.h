#pragma once

#include <Eigen/Eigenvalues>

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Writes the orthogonal H, n × n, of A = HTHᵀ, T of Hessenberg form. Unlike Eigen's product of
/// reflections, it does not allocate. `workspace` has n numbers.
template <class Scalar>
void write_householder_product(const Eigen::HessenbergDecomposition<Matrix<Scalar>>& A,
                               Vector<Scalar>& workspace, Matrix<Scalar>& H) {
  const Matrix<Scalar>& packed = A.packedMatrix();
  const Eigen::Index n = packed.rows();
  H.setIdentity(n, n);
  for (Eigen::Index k = n - 2; k >= 0; --k)
    H.bottomRightCorner(n - k - 1, n - k - 1)
        .applyHouseholderOnTheLeft(packed.col(k).tail(n - k - 2),
                                   A.householderCoefficients().coeff(k), workspace.data());
}

}  // namespace stiefel
