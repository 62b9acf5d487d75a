#pragma once

#include <Eigen/Core>
#include <limits>
#include <stop_token>

namespace stiefel {

struct Shot {
  Eigen::MatrixXd V;                                          ///< Q̇(0), n × N
  double residual = std::numeric_limits<double>::infinity();  ///< max |Q(T) − Q_T|
};

/// Returns max |Q(T) − Q_T| of the geodesic from Q_0 with momentum p (S for n < N, M for n = N),
/// integrated in extended precision; infinite when it cannot be integrated.
double miss(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q_0, const Eigen::MatrixXd& p,
            const Eigen::MatrixXd& Q_T, double T);

/// Returns S = VΛ for n < N, M = ΛΩ + ΩΛ for n = N.
Eigen::MatrixXd momentum(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q,
                         const Eigen::MatrixXd& V);

/// Corrects V until the geodesic from (Q_0, V) is at Q_T after a unit of time: Gauss–Newton on all
/// nN entries of Q(1) − Q_T, because the tangent entries alone have false zeros such as −Q_T. The
/// derivative comes from the variational equation; steps are halved while they do not reduce the
/// residual. On a stop request returns the best V so far.
Shot shoot(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q_0, const Eigen::MatrixXd& Q_T,
           const Eigen::MatrixXd& V, const std::stop_token& stop = {});

}  // namespace stiefel
