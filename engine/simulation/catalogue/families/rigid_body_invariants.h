#pragma once

#include <Eigen/Core>

#include "engine/simulation/stepping/invariant_list.h"
#include "stiefel/catalogue.h"

namespace stiefel {

/// The side on which the rotation group acts: Q̇ = QΩ on the left, Q̇ = ΩQ on the right.
enum class Side { left, right };

/// The invariants of (Q, M) in the rigid body's catalogue entry, but for orthogonality.
std::vector<InvariantInfo> rigid_body_invariant_infos(Side side = Side::left);

/// How M follows from a state, as far as its rounding goes; both in units of ‖M‖.
struct Rounding {
  /// The size of the matrices that M is a difference of; 0 where the state holds M itself.
  double terms = 0;
  /// Lower bound of the scale of M.
  double least_norm = 0;
};

/// Their values, in extended precision: QMQᵀ on the left, QᵀMQ on the right. Q is empty in a
/// momentum-only scene. The Manakov coefficients cost N⁵ operations, so unasked they come only up
/// to N = 16. The energy's scale is E, the others' are powers of ‖M‖. Of a body at rest, whose M is
/// rounding alone (at_rest.h), they are those of an M of the size of its terms.
void rigid_body_invariants(Side side, const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q,
                           const Eigen::MatrixXd& M, InvariantList& out, Rounding rounding = {});

/// ‖Ω‖, the operator norm.
double angular_velocity_norm(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& M);

}  // namespace stiefel
