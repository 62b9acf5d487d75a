#pragma once

#include <functional>
#include <vector>

#include "engine/dense/decompositions.h"
#include "engine/dense/taylor_motion.h"
#include "stiefel/stop.h"

namespace stiefel {

/// The Taylor coefficients of a geodesic on V(n, N), [ST] (37)–(39), Q over S: with V_k = S_kΛ⁻¹,
///
///     K_k = Σ_{j ≤ k} Q_j Λ⁻¹ Q_{k−j}ᵀ,
///     K_0 B_k + B_k K_0 = −2 Σ_{j ≤ k} V_j V_{k−j}ᵀ − Σ_{1 ≤ j ≤ k} (K_j B_{k−j} + B_{k−j} K_j),
///     (k+1) Q_{k+1} = V_k,   (k+1) S_{k+1} = Σ_{j ≤ k} B_j Q_{k−j}.
template <class Scalar_>
class TaylorStiefel {
 public:
  using Scalar = Scalar_;

  TaylorStiefel(const Vector<Scalar>& lambda, Eigen::Index n, int order)
      : inverse_(lambda.cwiseInverse()),
        order_(order),
        n_(n),
        K_(static_cast<std::size_t>(order), Matrix<Scalar>(n, n)),
        B_(K_),
        E_(n, n),
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
              const std::function<bool()>& stopped);

 private:
  Vector<Scalar> inverse_;
  int order_;
  Eigen::Index n_;
  std::vector<Matrix<Scalar>> K_, B_;
  Matrix<Scalar> E_;
  SymmetricLyapunov<Scalar> lyapunov_;
};

template <class Scalar>
bool TaylorStiefel<Scalar>::expand(const Matrix<Scalar>& x, Matrix<Scalar>& series,
                                   const std::function<bool()>& stopped) {
  const Eigen::Index N = x.cols();
  series.resize(x.rows(), (order_ + 1) * N);
  series.leftCols(N) = x;
  const auto Q = [&](int k) { return series.middleCols(k * N, N).topRows(n_); };
  const auto S = [&](int k) { return series.middleCols(k * N, N).bottomRows(n_); };
  for (int k = 0; k < order_; ++k) {
    if (stopped()) return false;
    Matrix<Scalar>&K = K_[static_cast<std::size_t>(k)], &B = B_[static_cast<std::size_t>(k)];
    K.setZero();
    E_.setZero();
    for (int j = 0; j <= k; ++j) {
      stop_point(static_cast<double>(2 * n_ * n_ * N));
      K += Q(j) * inverse_.asDiagonal() * Q(k - j).transpose();
      E_ -= Scalar(2) *
            ((S(j) * inverse_.asDiagonal()) * (S(k - j) * inverse_.asDiagonal()).transpose());
    }
    if (k == 0) lyapunov_.factor(K);
    for (int j = 1; j <= k; ++j) {
      stop_point(static_cast<double>(2 * n_ * n_ * n_));
      const auto &K_j = K_[static_cast<std::size_t>(j)], &B_i = B_[static_cast<std::size_t>(k - j)];
      E_ -= K_j * B_i + B_i * K_j;
    }
    lyapunov_.solve(E_, B);
    auto next = series.middleCols((k + 1) * N, N);
    next.topRows(n_) = S(k) * inverse_.asDiagonal();
    next.bottomRows(n_).setZero();
    for (int j = 0; j <= k; ++j) {
      stop_point(static_cast<double>(n_ * n_ * N));
      next.bottomRows(n_) += B_[static_cast<std::size_t>(j)] * Q(k - j);
    }
    next /= Scalar(k + 1);
  }
  return true;
}

// Compiled once, in frame_references.cc.
extern template class TaylorStiefel<long double>;
extern template class TaylorMotion<TaylorStiefel<long double>>;

}  // namespace stiefel
