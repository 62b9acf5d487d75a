#pragma once

#include "engine/numbers/scalar.h"
#include "engine/linalg/matrix_equations/lu.h"

namespace stiefel {

/// Returns εM_μ = Q_μ⁻¹P_μ − P_μ⁻¹Q_μ, [RB] (8.5) and (8.10) with the scaling of Prop. 3.13. M_μ =
/// M + μΛ², where M must be skew. tr((εM_μ)^k) and every eigenvalue of εM_μ are constant.
template <class Scalar>
Matrix<Scalar> parametric_momentum(const Matrix<Scalar>& Q, const Matrix<Scalar>& P) {
  return Q.partialPivLu().solve(P) - P.partialPivLu().solve(Q);
}

}  // namespace stiefel
