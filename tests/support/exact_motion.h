#pragma once

#include <Eigen/Core>

namespace stiefel::testing {

struct Motion {
  Eigen::MatrixXd Q, M;
};

/// Returns the solution of Q̇ = QΩ, Ṁ = [M, Ω] at time t, computed with Boost.odeint's
/// Bulirsch–Stoer method in extended precision. It shares no code with the engine.
Motion exact_motion(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q,
                    const Eigen::MatrixXd& M, double t, long double tolerance = 1e-17L);

}  // namespace stiefel::testing
