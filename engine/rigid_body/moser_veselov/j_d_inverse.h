#pragma once

#include "engine/rigid_body/body/outside_domain.h"

namespace stiefel {

/// Returns U = J_D⁻¹(K), K = hM skew: UΛ − ΛUᵀ = K, [RB] (7.13), on the branch that starts at the
/// identity, spec(UΛ) in Re > 0. If the branch has no solution, the error holds ‖K‖_op and, as
/// bound, the largest ‖tK‖_op, 0 ≤ t ≤ 1, that has a solution, to 1e-3.
MatrixWithin<double> J_D_inverse(const Vector<double>& lambda, const Matrix<double>& K);

}  // namespace stiefel
