#pragma once

#include <Eigen/Core>
#include <optional>

namespace stiefel {

/// Returns Q(1) of the geodesic ½ tr(ΛQ̇ᵀQ̇) from (Q_0, V), n ≤ N and every λ_i > 0, by Taylor
/// series of order 24 whose last terms are below rounding; nothing where it takes too many of them.
/// With V = Q̇, [ST] (37)–(39):
///
///     V̇ = BQΛ⁻¹,   KB + BK = −2VVᵀ,   K = QΛ⁻¹Qᵀ .
///
/// Allocates about 1 kB for each number of a frame. Each order takes three products that are
/// stacked over the orders below.
std::optional<Eigen::MatrixXd> geodesic_end(const Eigen::VectorXd& lambda,
                                            const Eigen::MatrixXd& Q_0, const Eigen::MatrixXd& V);

}  // namespace stiefel
