#pragma once

#include <Eigen/Core>
#include <optional>

#include "engine/frames/jacobi/short_conjugate.h"

namespace stiefel {

/// A closed geodesic of unit speed.
struct ClosedCurve {
  Eigen::MatrixXd Q, V;
  double length;
  double residual;  ///< largest entry of Q(length) − Q and of V(length) − V
};

/// Returns the closed geodesic in which one row of Q turns in the coordinate plane of the two
/// smallest λ and the others rest, an ellipse with the semi-axes √λ_1 and √λ_2; for n = N the body
/// turns in that plane, with the length 2π√(λ_1 + λ_2).
ClosedCurve planar_geodesic(const Eigen::VectorXd& lambda, Eigen::Index n);

/// Corrects (Q, V) and the length by Newton's method until the geodesic closes, with the least
/// change where closed geodesics come in families. Returns nothing where that fails.
std::optional<ClosedCurve> closed_near(const ShortConjugates& metric, const Eigen::MatrixXd& Q,
                                       const Eigen::MatrixXd& V, double length);

}  // namespace stiefel
