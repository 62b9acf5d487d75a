#include "engine/frame/geodesics/geodesic_series.h"

#include "engine/dense/taylor_rigid_body.h"
#include "engine/frame/taylor_stiefel.h"

namespace stiefel {

template class TaylorStiefel<double>;
template class TaylorMotion<TaylorStiefel<double>>;

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int terms = 24;

template <class Series>
std::optional<MatrixXd> end_of(Series series, const MatrixXd& Q, const MatrixXd& momentum) {
  constexpr int most = 400;  // series
  constexpr double rounding = 1e-17;
  MatrixXd x(2 * Q.rows(), Q.cols());
  x << Q, momentum;
  TaylorMotion<Series> motion(std::move(series), std::move(x), rounding);
  if (!motion.go_to(1, [&] { return motion.series_count() >= most; })) return {};
  return motion.state().topRows(Q.rows());
}

}  // namespace

MatrixXd momentum(const VectorXd& lambda, const MatrixXd& Q, const MatrixXd& V) {
  if (Q.rows() < Q.cols()) return V * lambda.asDiagonal();
  const MatrixXd twice = Q.transpose() * V - V.transpose() * Q;
  return (lambda.asDiagonal() * twice + twice * lambda.asDiagonal()) / 2;
}

std::optional<MatrixXd> geodesic_end(const VectorXd& lambda, const MatrixXd& Q_0,
                                     const MatrixXd& V) {
  const MatrixXd p = momentum(lambda, Q_0, V);
  if (Q_0.rows() == Q_0.cols()) return end_of(TaylorRigidBody<double>(lambda, terms), Q_0, p);
  return end_of(TaylorStiefel<double>(lambda, Q_0.rows(), terms), Q_0, p);
}

}  // namespace stiefel
