#pragma once

#include <Eigen/Core>

#include "tests/support/scenes/stacked.h"

namespace stiefel::testing {

/// Returns ‖M‖_op, the root of the largest eigenvalue of MᵀM.
double operator_norm(const Eigen::MatrixXd& M);

/// Returns P of Ψ⁻¹ for εM, [RB] Prop. 3.5: P = Q(εM/2 + (I + ε²M²/4)^{1/2}), computed with the
/// eigenvalues of the symmetric M².
Eigen::MatrixXd symmetric_P(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& M, double epsilon);

/// Returns the ε with ε‖M‖_op = 0.9.
double epsilon_for(const Eigen::MatrixXd& M);

/// P_μ with Q_μ⁻¹P_μ − P_μ⁻¹Q_μ = M + μΛ²: P_μ = Q_μX, X − X⁻¹ = Y, X = Y/2 + (I + Y²/4)^{1/2},
/// computed with the eigenvectors of Y.
Eigen::MatrixXd parametric_P(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& Y);

}  // namespace stiefel::testing
