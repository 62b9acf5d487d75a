#pragma once

#include <Eigen/Core>
#include <optional>

#include "engine/frame/geodesics/found.h"

namespace stiefel {

/// Whether Λ = λI to rounding.
bool is_round(const Eigen::VectorXd& lambda);

/// Returns the shortest geodesic from Q_0 to Q_T where a closed form proves that it is the
/// shortest; else nullopt. The cases are
///
///  n = N = 2 and V(1, 2): the frames form a circle. Both ways round are compared by their lengths
///           ∫ w dφ, w² = λ_1 + λ_2 for n = 2 and λ_1 sin²φ + λ_2 cos²φ for n = 1, an incomplete
///           elliptic integral of the second kind;
///  n = 1, Λ = λI: the great circle of length atan2(|Q_T − cQ_0|, c) ≤ π, c = Q_0Q_Tᵀ. Between
///           antipodes it is one of many;
///  n = N, Λ = λI: Q_0 exp(tW), W the logarithm of Q_0ᵀQ_T whose angles are at most π. The metric
///           is invariant on both sides, so its geodesics are these curves.
std::optional<Found> closed_geodesic(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q_0,
                                     const Eigen::MatrixXd& Q_T);

}  // namespace stiefel
