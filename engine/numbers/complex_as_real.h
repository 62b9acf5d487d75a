#pragma once

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Complex matrices in real numbers. Z = X + iY, p × q, is stored as X over Y, 2p × q, and acts as
///
///     R(Z) = [[X, −Y], [Y, X]],   R(WZ) = R(W)R(Z),   R(Z†) = R(Z)ᵀ,
///
/// The stored form is the left half of R(Z), so R(W)·stored(Z) = stored(WZ). Code for real matrices
/// of any scalar thereby serves complex ones, and a complex state is a block of real numbers.
/// `complex_as_real` writes R(Z).
template <class Stored, class Real>
void complex_as_real(const Eigen::MatrixBase<Stored>& stored, Eigen::MatrixBase<Real>& R) {
  const Eigen::Index p = stored.rows() / 2, q = stored.cols();
  R.leftCols(q) = stored;
  R.topRightCorner(p, q) = -stored.bottomRows(p);
  R.bottomRightCorner(p, q) = stored.topRows(p);
}

}  // namespace stiefel
