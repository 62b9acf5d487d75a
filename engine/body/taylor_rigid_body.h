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
template <class Scalar_>
class TaylorRigidBody {
 public:
  using Scalar = Scalar_;

  TaylorRigidBody(const Vector<Scalar>& lambda, int order)
      : lambda_(lambda), order_(order), N_(lambda.size()) {
    Omega_.resize((order + 1) * N_, N_);
  }

  int order() const { return order_; }
  /// Returns the number of lower rows of the state, whose error is measured separately.
  Eigen::Index momentum_rows() const { return N_; }
  /// Returns the operations of a whole series, 2 for a multiplication with its addition.
  static double operations(Eigen::Index rows, Eigen::Index N, int order) {
    return static_cast<double>(order * (order + 1) * rows * N * N);
  }

  /// Computes the series at x, with coefficient k in the columns from kN on. Returns false on a
  /// stop request.
  bool expand(const Matrix<Scalar>& x, Matrix<Scalar>& series,
              const std::function<bool()>& stopped);

 private:
  /// Returns Ω_k. Stored in reverse order, so that the sum runs down a column.
  auto Omega(int k) { return Omega_.middleRows((order_ - k) * N_, N_); }

  Vector<Scalar> lambda_;
  int order_;
  Eigen::Index N_;
  Matrix<Scalar> Omega_, Y_;
};

template <class Scalar>
bool TaylorRigidBody<Scalar>::expand(const Matrix<Scalar>& x, Matrix<Scalar>& series,
                                     const std::function<bool()>& stopped) {
  series.resize(x.rows(), (order_ + 1) * N_);
  series.leftCols(N_) = x;
  for (int k = 0; k < order_; ++k) {
    if (stopped()) return false;
    inverse_inertia(lambda_, series.middleCols(k * N_, N_).bottomRows(N_), Omega(k));
    auto next = series.middleCols((k + 1) * N_, N_);
    stop_point(static_cast<double>((k + 1) * x.size() * N_));
    Y_.noalias() = series.leftCols((k + 1) * N_) * Omega_.bottomRows((k + 1) * N_);
    next = Y_;
    next.bottomRows(N_) -= Y_.bottomRows(N_).transpose();
    next /= Scalar(k + 1);
  }
  return true;
}

// Compiled once, in body_references.cc.
extern template class TaylorRigidBody<long double>;
extern template class TaylorMotion<TaylorRigidBody<long double>>;

}  // namespace stiefel
