#pragma once

#include "stiefel/conjugate_points.h"
#include "tests/support/scenes/two_frames.h"

namespace stiefel::testing {

/// Returns √tr(V Λ Vᵀ).
inline double norm(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& V) {
  return std::sqrt((V.cwiseAbs2() * lambda).sum());
}

/// Returns a random geodesic of unit speed on V(n, N).
inline GeodesicRay random_ray(const Eigen::VectorXd& lambda, Eigen::Index n, double time,
                              unsigned seed) {
  const TwoPointProblem frames =
      random_frames(static_cast<int>(n), static_cast<int>(lambda.size()), 1, seed);
  const Eigen::MatrixXd half = frames.Q_T * frames.Q_0.transpose();
  const Eigen::MatrixXd V = frames.Q_T - (half + half.transpose()) / 2 * frames.Q_0;
  return {lambda, frames.Q_0, V / norm(lambda, V), time};
}

}  // namespace stiefel::testing
