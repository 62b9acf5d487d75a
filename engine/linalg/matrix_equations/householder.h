#pragma once

#include <Eigen/Householder>

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Writes the orthogonal H = H_1 ⋯ H_{n−1} of a reduction to Hessenberg or tridiagonal form as a
/// matrix, from the reflections that Eigen packs below the first subdiagonal of `packed`. Unlike
/// Eigen's product, it does not allocate. `workspace` has n numbers.
template <class Scalar, class Coefficients>
void write_householder_product(const Matrix<Scalar>& packed, const Coefficients& coefficients,
                               Vector<Scalar>& workspace, Matrix<Scalar>& H) {
  const Eigen::Index n = packed.rows();
  H.setIdentity(n, n);
  for (Eigen::Index k = n - 2; k >= 0; --k)
    H.bottomRightCorner(n - k - 1, n - k - 1)
        .applyHouseholderOnTheLeft(packed.col(k).tail(n - k - 2),
                                   Eigen::numext::conj(coefficients.coeff(k)), workspace.data());
}

}  // namespace stiefel
