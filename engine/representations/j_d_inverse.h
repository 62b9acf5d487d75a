#pragma once

#include "engine/representations/outside_domain.h"

namespace stiefel {

/// U = J_D⁻¹(K), K = hM skew: UΛ − ΛUᵀ = K, [RB] (7.13), on the branch that starts at the identity,
/// spec(UΛ) in Re > 0. Where that has none: ‖K‖_op, and the ‖tK‖_op up to which it exists on the
/// ray of K, to 1e-3.
MatrixWithin<double> J_D_inverse(const Vector<double>& lambda, const Matrix<double>& K);

}  // namespace stiefel
