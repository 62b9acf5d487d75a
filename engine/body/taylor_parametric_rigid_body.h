#pragma once

#include <functional>

#include "engine/dense/inertia_operator.h"
#include "engine/dense/taylor_motion.h"
#include "engine/motion/series_start.h"
#include "stiefel/stop.h"

namespace stiefel {

/// The Taylor coefficients of the rigid body with parameter μ, [RB] (8.4)–(8.6), in Q_μ and M_μ =
/// Q_μ⁻¹P_μ − P_μ⁻¹Q_μ, which need no inverse during the motion. With ξ = Ω + μΛ, Ω = J⁻¹ of the
/// skew part of M_μ,
///
///     (k+1) Q_{k+1} = Σ_{j ≤ k} Q_j ξ_{k−j},
///     (k+1) M_{k+1} = Σ_{j ≤ k} (M_j ξ_{k−j} − ξ_j M_{k−j}).
///
/// A state is Q over M_μ, 2N × N.
template <class Scalar_>
class TaylorParametricRigidBody {
 public:
  using Scalar = Scalar_;

  TaylorParametricRigidBody(const Vector<Scalar>& lambda, const Scalar& mu, int order)
      : lambda_(lambda), mu_(mu), order_(order), N_(lambda.size()), xi_((order + 1) * N_, N_) {}

  int order() const { return order_; }
  /// Returns the number of lower rows of the state, whose error is measured separately.
  Eigen::Index momentum_rows() const { return N_; }
  /// Returns the operations of a whole series, 2 for a multiplication with its addition.
  static double operations(Eigen::Index rows, Eigen::Index N, int order) {
    return static_cast<double>(order * (order + 1) * (rows + N) * N * N);
  }

  /// Computes the series at x, with coefficient k in the columns from kN on. Returns false on a
  /// stop request.
  bool expand(const Matrix<Scalar>& x, Matrix<Scalar>& series,
              const std::function<bool()>& stopped);

 private:
  /// Returns ξ_k. Stored in reverse order, so that the sum runs down a column.
  auto xi(int k) { return xi_.middleRows((order_ - k) * N_, N_); }

  Vector<Scalar> lambda_;
  Scalar mu_;
  int order_;
  Eigen::Index N_;
  Matrix<Scalar> xi_;
};

template <class Scalar>
bool TaylorParametricRigidBody<Scalar>::expand(const Matrix<Scalar>& x, Matrix<Scalar>& series,
                                               const std::function<bool()>& stopped) {
  series.resize(x.rows(), (order_ + 1) * N_);
  series.leftCols(N_) = x;
  const auto M = [&](int k) { return series.middleCols(k * N_, N_).bottomRows(N_); };
  for (int k = 0; k < order_; ++k) {
    if (stopped()) return false;
    auto now = xi(k);
    inverse_inertia(lambda_, M(k), Scalar(2), now);
    if (k == 0) now.diagonal() = mu_ * lambda_;
    auto next = series.middleCols((k + 1) * N_, N_);
    stop_point(static_cast<double>((k + 1) * x.size() * N_));
    next.noalias() = series.leftCols((k + 1) * N_) * xi_.bottomRows((k + 1) * N_);
    for (int j = 0; j <= k; ++j) {
      stop_point(static_cast<double>(N_ * N_ * N_));
      next.bottomRows(N_).noalias() -= xi(j) * M(k - j);
    }
    next /= Scalar(k + 1);
  }
  return true;
}

/// The references of these equations.
extern const SeriesEquations parametric_equations;

// Compiled once, in taylor_parametric_rigid_body.cc.
extern template class TaylorParametricRigidBody<long double>;
extern template class TaylorMotion<TaylorParametricRigidBody<long double>>;

}  // namespace stiefel
