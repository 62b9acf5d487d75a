#pragma once

#include <Eigen/Core>

#include "engine/stepping/invariant_list.h"
#include "stiefel/catalogue.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

/// The invariant that discrete rigid bodies keep in addition to those of the continuous one.
inline constexpr InvariantInfo discrete_hamiltonian_info = {
    family::discrete_hamiltonian,
    "tr exp(asinh(h M / 2)) - tr(Lambda U), U Lambda - Lambda U^T = h M", "[RB] (6.17)"};

/// Adds the discrete Hamiltonian where h‖M‖_op ≤ 2 and J_D⁻¹(hM) is on the principal branch;
/// elsewhere adds nothing. Call it after all other families.
void add_discrete_hamiltonian(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& M, double h,
                              InvariantList& out);

}  // namespace stiefel
