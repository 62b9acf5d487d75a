#include "engine/frame/geodesics/geodesic_series.h"

#include <algorithm>
#include <cmath>

#include "engine/dense/decompositions.h"
#include "engine/frame/geodesics/connect_work.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

class GeodesicSeries {
 public:
  static constexpr Index order = 24;

  GeodesicSeries(const VectorXd& lambda, Index n)
      : inverse_(lambda.cwiseInverse()),
        n_(n),
        N_(lambda.size()),
        Q_(n, (order + 1) * N_),
        V_(n, (order + 1) * N_),
        Q_back_(n, (order + 1) * N_),
        V_back_(n, (order + 1) * N_),
        force_back_((order + 1) * n, N_),
        B_(n, order * n),
        K_(n, order * n),
        E_(n, n),
        X_(n, n),
        lyapunov_(n) {}

  /// Computes the coefficients at (Q, V).
  void expand(const MatrixXd& Q, const MatrixXd& V) {
    stop_point(4 * order * connect_work::frame(n_, N_));
    set(0, Q, V);
    for (Index k = 0; k < order; ++k) {
      const Index from = (order - k) * N_, all = (k + 1) * N_;
      auto K = K_.middleCols(k * n_, n_);
      K.noalias() = Q_.leftCols(all) * Q_back_.middleCols(from, all).transpose();
      E_.noalias() = V_.leftCols(all) * V_back_.middleCols(from, all).transpose();
      E_ *= -2;
      for (Index j = 1; j <= k; ++j) {
        X_.noalias() = K_.middleCols(j * n_, n_) * B_.middleCols((k - j) * n_, n_);
        E_ -= X_ + X_.transpose();
      }
      if (k == 0) lyapunov_.factor(K);
      X_ = (E_ + E_.transpose()) / 2;
      lyapunov_.solve(X_, X_);
      B_.middleCols(k * n_, n_) = X_;
      const double next = static_cast<double>(k + 1);
      set(k + 1, V_.middleCols(k * N_, N_) / next,
          B_.leftCols((k + 1) * n_) * force_back_.middleRows((order - k) * n_, (k + 1) * n_) /
              next);
    }
  }

  /// Returns the time up to which the last two terms are below rounding.
  double reach() const {
    constexpr double rounding = 1e-17;
    double reach = std::numeric_limits<double>::infinity();
    for (const auto* x : {&Q_, &V_}) {
      const auto size = [&](Index k) { return x->middleCols(k * N_, N_).cwiseAbs().maxCoeff(); };
      for (const Index k : {order - 1, order})
        reach = std::min(reach, std::pow(rounding * size(0) / size(k), 1 / static_cast<double>(k)));
    }
    return reach;
  }

  void evaluate(double t, MatrixXd& Q, MatrixXd& V) const {
    Q = Q_.rightCols(N_);
    V = V_.rightCols(N_);
    for (Index k = order; k-- > 0;) {
      Q = t * Q + Q_.middleCols(k * N_, N_);
      V = t * V + V_.middleCols(k * N_, N_);
    }
  }

 private:
  template <class A, class B>
  void set(Index k, const A& Q, const B& V) {
    Q_.middleCols(k * N_, N_) = Q;
    V_.middleCols(k * N_, N_) = V;
    const Index back = order - k;
    V_back_.middleCols(back * N_, N_) = V_.middleCols(k * N_, N_);
    auto force = force_back_.middleRows(back * n_, n_);
    force = Q_.middleCols(k * N_, N_) * inverse_.asDiagonal();
    Q_back_.middleCols(back * N_, N_) = force;
  }

  VectorXd inverse_;
  Index n_, N_;
  MatrixXd Q_, V_;            ///< coefficient k in the columns from kN on
  MatrixXd Q_back_, V_back_;  ///< QΛ⁻¹ and V in descending order
  MatrixXd force_back_;       ///< QΛ⁻¹ in descending order, one below the other
  MatrixXd B_, K_, E_, X_;
  SymmetricLyapunov<double> lyapunov_;
};

}  // namespace

std::optional<MatrixXd> geodesic_end(const VectorXd& lambda, const MatrixXd& Q_0,
                                     const MatrixXd& V) {
  constexpr int most = 400;
  GeodesicSeries series(lambda, Q_0.rows());
  MatrixXd Q = Q_0, v = V;
  double left = 1;
  for (int k = 0; k < most; ++k) {
    series.expand(Q, v);
    const double reach = series.reach();
    if (!(reach > 0)) return {};
    const double h = std::min(left, reach);
    series.evaluate(h, Q, v);
    left -= h;
    if (!(left > 0)) return Q;
    if (!Q.allFinite()) return {};
  }
  return {};
}

}  // namespace stiefel
