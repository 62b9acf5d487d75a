#include "engine/frame/geodesics/geodesic_series.h"

#include "engine/dense/inertia_operator.h"
#include "engine/frame/taylor_stiefel.h"

namespace stiefel {

template class TaylorStiefel<double>;
template class TaylorMotion<TaylorStiefel<double>>;

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int terms = 24;

/// The Taylor coefficients of the geodesics at n = N, Q over M: with Ω_k = J⁻¹(M_k),
///
///     (k+1) Q_{k+1} = Σ_{j ≤ k} Q_j Ω_{k−j},   (k+1) M_{k+1} = Σ_{j ≤ k} [M_j, Ω_{k−j}].
class BodySeries {
 public:
  using Scalar = double;

  explicit BodySeries(const VectorXd& lambda) : lambda_(lambda), Omega_(terms) {}

  int order() const { return terms; }
  Index momentum_rows() const { return lambda_.size(); }

  bool expand(const MatrixXd& x, MatrixXd& series, const std::function<bool()>& stopped) {
    const Index N = x.cols();
    series.resize(2 * N, (order() + 1) * N);
    series.leftCols(N) = x;
    for (int k = 0; k < order(); ++k) {
      if (stopped()) return false;
      stop_point(static_cast<double>(3 * (k + 1) * N * N * N));
      const auto M = [&](int j) { return series.middleCols(j * N, N).bottomRows(N); };
      Omega_[static_cast<std::size_t>(k)] = inverse_inertia<double>(lambda_, M(k));
      auto next = series.middleCols((k + 1) * N, N);
      next.setZero();
      for (int j = 0; j <= k; ++j) {
        const MatrixXd& Omega = Omega_[static_cast<std::size_t>(k - j)];
        next.noalias() += series.middleCols(j * N, N) * Omega;
        next.bottomRows(N).noalias() -= Omega * M(j);
      }
      next /= k + 1.0;
    }
    return true;
  }

 private:
  VectorXd lambda_;
  std::vector<MatrixXd> Omega_;
};

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
  if (Q_0.rows() == Q_0.cols()) return end_of(BodySeries(lambda), Q_0, p);
  return end_of(TaylorStiefel<double>(lambda, Q_0.rows(), terms), Q_0, p);
}

}  // namespace stiefel
