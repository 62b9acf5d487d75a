#pragma once

#include <Eigen/Core>

#include "engine/simulation/catalogue.h"
#include "engine/simulation/invariant_list.h"

namespace stiefel {

/// The invariants of (Q, M) in the rigid body's catalogue entry, but for orthogonality.
std::vector<InvariantInfo> rigid_body_invariant_infos();

/// Their values, in extended precision. Q is empty in a momentum-only scene. The Manakov
/// coefficients cost N⁵ operations, so unasked they come only up to N = 16. Scales are those of
/// ‖M‖, or of `least_norm` where M is a difference of larger matrices, whose rounding it has.
void rigid_body_invariants(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q,
                           const Eigen::MatrixXd& M, InvariantList& out, double least_norm = 0);

/// ‖Ω‖, the operator norm.
double angular_velocity_norm(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& M);

}  // namespace stiefel
