#pragma once

#include <Eigen/Core>
#include <optional>

#include "stiefel/connect.h"

namespace stiefel {

/// Returns what is wrong with Λ as a metric tr(ΛQ̇ᵀQ̇) on V(n, N), for n = N on SO(N).
std::optional<refusal::Invalid> metric_fault(const Eigen::VectorXd& inertia, Eigen::Index n,
                                             Eigen::Index N);

}  // namespace stiefel
