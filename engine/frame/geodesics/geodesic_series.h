#pragma once

#include <Eigen/Core>
#include <optional>

namespace stiefel {

/// Returns S = VΛ for n < N, M = ΛΩ + ΩΛ, Ω = QᵀV, for n = N.
Eigen::MatrixXd momentum(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q,
                         const Eigen::MatrixXd& V);

struct GeodesicEnd {
  Eigen::MatrixXd Q, V;
};

/// Returns Q(1) and Q̇(1) of the geodesic ½ tr(ΛQ̇ᵀQ̇) from (Q_0, V) by Taylor series of order 24
/// whose last terms are below rounding; nothing where it takes too many of them. Allocates about
/// 1 kB for each number of a frame.
std::optional<GeodesicEnd> geodesic_end(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q_0,
                                        const Eigen::MatrixXd& V);

}  // namespace stiefel
