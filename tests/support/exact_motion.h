#pragma once

#include <Eigen/Core>

namespace stiefel::testing {

struct Motion {
  Eigen::MatrixXd Q, M;
};

/// Q̇ = QΩ, Ṁ = [M, Ω] at time t by Boost.odeint's Bulirsch–Stoer in extended precision: the plain
/// vector field in plain matrices, no code of the engine.
Motion exact_motion(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q,
                    const Eigen::MatrixXd& M, double t, long double tolerance = 1e-17L);

}  // namespace stiefel::testing
