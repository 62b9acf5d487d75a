#pragma once

#include <algorithm>
#include <cmath>

#include "engine/dense/decompositions.h"
#include "engine/numbers/scalar.h"
#include "stiefel/stop.h"

namespace stiefel {

/// One sweep of the fixed-point iteration for the Cayley transform U = (I − C)⁻¹(I + C) of
/// J_D⁻¹(hM). With q = C(I − C²)⁻¹ and D = Cq, the skew and the symmetric part of ½(U − I),
///
///     C ← C + ½ (I + C)ω(I − C),   ω = hΩ − 2q + 2 D∘(λ_i − λ_j)/(λ_i + λ_j),
///
/// which turns U into U(I + ω) to first order. ω is −(UΛ − ΛUᵀ − hM)_ij/(λ_i + λ_j), with each term
/// divided by λ_i + λ_j before the sum. Λ then enters only through Ω and ratios of at most 1, so
/// each sweep reduces the error by a factor of about h‖Ω‖, and C keeps its digits however wide Λ is
/// spread.
template <class Scalar>
class CayleySweep {
 public:
  explicit CayleySweep(const Vector<Scalar>& lambda)
      : lambda_(lambda),
        ratio_(lambda.size(), lambda.size()),
        q_(ratio_),
        D_(ratio_),
        product_(ratio_) {
    for (Eigen::Index j = 0; j < ratio_.cols(); ++j)
      for (Eigen::Index i = 0; i < ratio_.rows(); ++i)
        ratio_(i, j) = i == j ? Scalar(0) : (lambda(i) - lambda(j)) / (lambda(i) + lambda(j));
  }

  const Vector<Scalar>& lambda() const { return lambda_; }

  /// Makes one sweep. Returns the largest element of ω.
  Scalar operator()(const Matrix<Scalar>& hOmega, Matrix<Scalar>& C) {
    evaluate(C);
    q_ = hOmega - Scalar(2) * (q_ - ratio_.cwiseProduct(D_));  // ω
    const Scalar size = q_.cwiseAbs().maxCoeff();
    product_ = q_;
    look();
    product_.noalias() += -q_ * C;
    q_ = product_;
    look();
    q_.noalias() += C * product_;
    for (Eigen::Index j = 0; j < C.cols(); ++j)
      for (Eigen::Index i = 0; i < j; ++i) {
        C(i, j) += (q_(i, j) - q_(j, i)) / 4;
        C(j, i) = -C(i, j);
      }
    return size;
  }

  /// Computes q and D for this C.
  void evaluate(const Matrix<Scalar>& C) {
    look();
    product_.noalias() = C.transpose() * C;
    product_.diagonal().array() += Scalar(1);
    look();
    factor_positive(product_);
    q_ = C;
    look();
    solve_positive(product_, q_);
    look();
    D_.noalias() = C * q_;
  }

  /// Returns D for the C of the last `evaluate`.
  const Matrix<Scalar>& D() const { return D_; }
  const Matrix<Scalar>& U_minus_I() {
    product_ = Scalar(2) * (q_ + D_);
    return product_;
  }

 private:
  /// Checks for a stop request. Called before each product: one product takes long in extended
  /// precision.
  void look() const { stop_point(static_cast<double>(ratio_.rows() * ratio_.size())); }

  Vector<Scalar> lambda_;
  Matrix<Scalar> ratio_, q_, D_, product_;
};

}  // namespace stiefel
