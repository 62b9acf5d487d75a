#pragma once

#include <functional>

#include "engine/dense/inertia_operator.h"
#include "engine/dense/taylor_motion.h"
#include "engine/numbers/scalar.h"
#include "stiefel/stop.h"

namespace stiefel {

/// The Taylor coefficients of a free rigid body's motion, X_k = (Q_k; M_k), Ω_k = J⁻¹(M_k): with
/// [M, Ω] = MΩ − (MΩ)ᵀ,
///
///     Y_k = Σ_{j ≤ k} X_j Ω_{k−j},   (k+1) Q_{k+1} = the rows of Q in Y_k,
///                                    (k+1) M_{k+1} = the rows of M in Y_k, minus their transpose.
///
/// A state is Q over M, 2N × N, or M alone. The sum is one product of two block matrices.
///
/// `parametric`: those of the rigid body with parameter μ, [RB] (8.4)–(8.6), in Q_μ and M_μ =
/// Q_μ⁻¹P_μ − P_μ⁻¹Q_μ, which need no inverse during the motion. With ξ = Ω + μΛ in the place of Ω,
/// Ω = J⁻¹ of the skew part of M_μ,
///
///     (k+1) M_{k+1} = Σ_{j ≤ k} (M_j ξ_{k−j} − ξ_j M_{k−j}).
template <class Scalar_, bool parametric = false>
class TaylorRigidBody {
 public:
  using Scalar = Scalar_;

  TaylorRigidBody(const Vector<Scalar>& lambda, int order) : TaylorRigidBody(lambda, 0, order) {}
  TaylorRigidBody(const Vector<Scalar>& lambda, const Scalar& mu, int order)
      : lambda_(lambda), mu_(mu), order_(order), N_(lambda.size()), xi_((order + 1) * N_, N_) {}

  int order() const { return order_; }
  /// Returns the number of lower rows of the state, whose error is measured separately.
  Eigen::Index momentum_rows() const { return N_; }
  /// Returns the operations of a whole series, 2 for a multiplication with its addition.
  static double operations(Eigen::Index rows, Eigen::Index N, int order) {
    return static_cast<double>(order * (order + 1) * (rows + (parametric ? N : 0)) * N * N);
  }

  /// Computes the series at x, with coefficient k in the columns from kN on. Returns false on a
  /// stop request.
  bool expand(const Matrix<Scalar>& x, Matrix<Scalar>& series,
              const std::function<bool()>& stopped) {
    series.resize(x.rows(), (order_ + 1) * N_);
    series.leftCols(N_) = x;
    Y_.resize(x.rows(), N_);
    const auto M = [&](int k) { return series.middleCols(k * N_, N_).bottomRows(N_); };
    for (int k = 0; k < order_; ++k) {
      if (stopped()) return false;
      auto now = xi(k);
      if constexpr (parametric)
        inverse_inertia(lambda_, M(k), Scalar(2), now);
      else
        inverse_inertia(lambda_, M(k), now);
      if (parametric && k == 0) now.diagonal() = mu_ * lambda_;
      stop_point(static_cast<double>((k + 1) * x.size() * N_));
      Y_.noalias() = series.leftCols((k + 1) * N_) * xi_.bottomRows((k + 1) * N_);
      if constexpr (parametric) {
        for (int j = 0; j <= k; ++j) {
          stop_point(static_cast<double>(N_ * N_ * N_));
          Y_.bottomRows(N_).noalias() -= xi(j) * M(k - j);
        }
      } else {
        subtract_transpose(Y_.bottomRows(N_));
      }
      series.middleCols((k + 1) * N_, N_) = Y_ / Scalar(k + 1);
    }
    return true;
  }

 private:
  /// Returns Ω_k or ξ_k. Stored in reverse order, so that the sum runs down a column.
  auto xi(int k) { return xi_.middleRows((order_ - k) * N_, N_); }

  Vector<Scalar> lambda_;
  Scalar mu_;
  int order_;
  Eigen::Index N_;
  Matrix<Scalar> xi_, Y_;
};

// Compiled once, in body_references.cc.
extern template class TaylorRigidBody<long double>;
extern template class TaylorRigidBody<long double, true>;
extern template class TaylorMotion<TaylorRigidBody<long double>>;
extern template class TaylorMotion<TaylorRigidBody<long double, true>>;

}  // namespace stiefel
