#pragma once

#include "engine/dense/decompositions.h"

namespace stiefel {

enum class MatrixKind { skew, general };

/// Computes D = exp(A) − I of a real N × N matrix A, by the diagonal Padé approximant of degree 7
/// with scaling and squaring (Higham 2005): r = (V − U)⁻¹(V + U), U odd and V even in A. D is
/// computed directly and doubled by exp(2A) − I = 2D + D², so it is relatively accurate for small
/// A. For a skew A, r is orthogonal to rounding. Each doubling doubles the rounding error, so some
/// are then followed by the projection of U = I + D to the orthogonal matrices, U ← U(3I − UᵀU)/2.
/// Allocates at construction only. Compiled once, for double and long double.
template <class Scalar>
class Exponential {
 public:
  Exponential(Eigen::Index N, MatrixKind of);

  void operator()(const Matrix<Scalar>& A, Matrix<Scalar>& D);

 private:
  void restore_orthogonality(Matrix<Scalar>& D);

  MatrixKind of_;
  Matrix<Scalar> scaled_, square_, fourth_, sixth_, odd_, even_;
  Lu<Scalar> lu_;
};

}  // namespace stiefel
