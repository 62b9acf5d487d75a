#include "engine/frame/geodesics/geodesic_series.h"

#include "engine/dense/taylor_rigid_body.h"
#include "engine/frame/taylor_stiefel.h"

namespace stiefel {

template class TaylorStiefel<double>;
template class TaylorMotion<TaylorStiefel<double>>;

namespace {

constexpr int terms = 24;

/// `velocity` returns Q̇ of Q and the momentum.
template <class Series>
std::optional<GeodesicEnd> end_of(Series series, const MatrixXd& Q, const MatrixXd& momentum,
                                  const auto& velocity) {
  constexpr int most = 400;  // series
  constexpr double rounding = 1e-17;
  MatrixXd x(2 * Q.rows(), Q.cols());
  x << Q, momentum;
  TaylorMotion<Series> motion(std::move(series), std::move(x), rounding);
  if (!motion.go_to(1, [&] { return motion.series_count() >= most; })) return {};
  const MatrixXd end = motion.state().topRows(Q.rows());
  return GeodesicEnd{end, velocity(end, motion.state().bottomRows(Q.rows()))};
}

}  // namespace

MatrixXd momentum(const VectorXd& lambda, const MatrixXd& Q, const MatrixXd& V) {
  if (Q.rows() < Q.cols()) return V * lambda.asDiagonal();
  const MatrixXd twice = Q.transpose() * V - V.transpose() * Q;
  return (lambda.asDiagonal() * twice + twice * lambda.asDiagonal()) / 2;
}

std::optional<GeodesicEnd> geodesic_end(const VectorXd& lambda, const MatrixXd& Q_0,
                                        const MatrixXd& V) {
  const MatrixXd p = momentum(lambda, Q_0, V);
  if (Q_0.rows() == Q_0.cols())
    return end_of(TaylorRigidBody<double>(lambda, terms), Q_0, p,
                  [&](const MatrixXd& Q, const MatrixXd& M) -> MatrixXd {
                    return Q * inverse_inertia<double>(lambda, M);
                  });
  return end_of(TaylorStiefel<double>(lambda, Q_0.rows(), terms), Q_0, p,
                [&](const MatrixXd&, const MatrixXd& S) -> MatrixXd {
                  return S * lambda.cwiseInverse().asDiagonal();
                });
}

}  // namespace stiefel
