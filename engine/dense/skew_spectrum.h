#pragma once

#include <algorithm>

#include "engine/dense/decompositions.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Returns ‖M‖_op of an N × N matrix to rounding, which for a skew M is the largest |eigenvalue|.
/// Computes the square root of the largest eigenvalue of MᵀM, with M scaled so that its square
/// neither overflows nor underflows.
template <class Scalar>
Scalar skew_norm(const Matrix<Scalar>& M) {
  using std::sqrt;
  const Scalar size = M.size() == 0 ? Scalar(0) : Scalar(M.cwiseAbs().maxCoeff());
  if (!(size > 0)) return size;
  stop_point(3 * static_cast<double>(M.rows() * M.size()));
  const Matrix<Scalar> unit = M / size, square = unit.transpose() * unit;
  return size * sqrt(symmetric_eigenvalues(square)(M.cols() - 1));
}

/// Returns the Casimirs of so(N)*: w ≥ 0 of the eigenvalues ±iw of M, in descending order, one for
/// each pair. Computed from MᵀM they would keep only half the digits.
template <class Scalar>
Vector<Scalar> casimirs(const Matrix<Scalar>& M) {
  return skew_eigenvalues(M).reverse().head(M.cols() / 2);
}

// Compiled once, in angular_velocity.cc.
extern template double skew_norm(const Matrix<double>& M);
extern template Vector<double> casimirs(const Matrix<double>& M);

}  // namespace stiefel
