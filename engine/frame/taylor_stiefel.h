#pragma once

#include <functional>

#include "engine/dense/decompositions.h"
#include "engine/dense/taylor_motion.h"
#include "stiefel/stop.h"

namespace stiefel {

/// The Taylor coefficients of a geodesic on V(n, N), [ST] (37)–(39), Q over S:
///
///     K_k = Σ_{j ≤ k} Q_j (Q_{k−j} Λ⁻¹)ᵀ,
///     K_0 B_k + B_k K_0 = −2 Σ_{j ≤ k} S_j (S_{k−j} Λ⁻²)ᵀ − Σ_{1 ≤ j ≤ k} (K_j B_{k−j} + B_{k−j}
///     K_j), (k+1) Q_{k+1} = S_k Λ⁻¹,   (k+1) S_{k+1} = Σ_{j ≤ k} B_j Q_{k−j}.
///
/// Coefficients stand side by side, so that an order takes three products over all orders below.
template <class Scalar_>
class TaylorStiefel {
 public:
  using Scalar = Scalar_;

  TaylorStiefel(const Vector<Scalar>& lambda, Eigen::Index n, int order)
      : inverse_(lambda.cwiseInverse()),
        order_(order),
        n_(n),
        weighted_(2 * n, (order + 1) * lambda.size()),
        below_((order + 1) * n, lambda.size()),
        K_(n, order * n),
        B_(K_),
        E_(n, n),
        X_(n, n),
        lyapunov_(n) {}

  int order() const { return order_; }
  /// Returns the number of lower rows of the state, whose error is measured separately.
  Eigen::Index momentum_rows() const { return n_; }
  /// Returns the operations of a whole series, 2 for a multiplication with its addition, plus a
  /// constant for each small product.
  static double operations(Eigen::Index rows, Eigen::Index N, int order) {
    const double n = static_cast<double>(rows) / 2;
    return order * (order + 1) * (30 + 3 * n * n * static_cast<double>(N) + 2 * n * n * n);
  }

  /// Computes the series at x, with coefficient k in the columns from kN on. Returns false on a
  /// stop request.
  bool expand(const Matrix<Scalar>& x, Matrix<Scalar>& series,
              const std::function<bool()>& stopped) {
    const Eigen::Index N = x.cols(), n = n_;
    series.resize(x.rows(), (order_ + 1) * N);
    series.leftCols(N) = x;
    for (int k = 0; k < order_; ++k) {
      if (stopped()) return false;
      stop_point(static_cast<double>(3 * (k + 1) * n * n * N));
      const auto Q = series.middleCols(k * N, N).topRows(n),
                 S = series.middleCols(k * N, N).bottomRows(n);
      const Eigen::Index back = order_ - k, all = (k + 1) * N;
      weighted_.middleCols(back * N, N).topRows(n) = Q * inverse_.asDiagonal();
      weighted_.middleCols(back * N, N).bottomRows(n) = S * inverse_.cwiseAbs2().asDiagonal();
      below_.middleRows(back * n, n) = Q;
      const auto weighted = weighted_.middleCols(back * N, all);
      auto K = K_.middleCols(k * n, n), B = B_.middleCols(k * n, n);
      K.noalias() = series.leftCols(all).topRows(n) * weighted.topRows(n).transpose();
      E_.noalias() = series.leftCols(all).bottomRows(n) * weighted.bottomRows(n).transpose();
      E_ *= Scalar(-2);
      for (int j = 1; j <= k; ++j) {
        X_.noalias() = K_.middleCols(j * n, n) * B_.middleCols((k - j) * n, n);
        E_ -= X_ + X_.transpose();
      }
      if (k == 0) lyapunov_.factor(K);
      X_ = (E_ + E_.transpose()) / Scalar(2);
      lyapunov_.solve(X_, X_);
      B = X_;
      auto next = series.middleCols((k + 1) * N, N);
      next.topRows(n) = S * inverse_.asDiagonal();
      next.bottomRows(n).noalias() =
          B_.leftCols((k + 1) * n) * below_.middleRows(back * n, (k + 1) * n);
      next /= Scalar(k + 1);
    }
    return true;
  }

 private:
  Vector<Scalar> inverse_;
  int order_;
  Eigen::Index n_;
  Matrix<Scalar> weighted_, below_;  ///< QΛ⁻¹ over SΛ⁻², and Q, in descending order
  Matrix<Scalar> K_, B_, E_, X_;
  SymmetricLyapunov<Scalar> lyapunov_;
};

// Compiled once, in geodesics/geodesic_series.cc and geodesics/frame_references.cc.
extern template class TaylorStiefel<double>;
extern template class TaylorMotion<TaylorStiefel<double>>;
extern template class TaylorStiefel<long double>;
extern template class TaylorMotion<TaylorStiefel<long double>>;

}  // namespace stiefel
