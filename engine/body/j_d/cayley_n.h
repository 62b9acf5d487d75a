#pragma once

#include <algorithm>
#include <cmath>

#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"
#include "engine/numbers/compensated.h"
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

/// U = J_D⁻¹(K), K = hM, in N dimensions as the Cayley transform U = (I − C)⁻¹(I + C), C skew:
///
///     F(C) = ΛC + CΛ − ½ (I − C) K (I + C) = 0.
///
/// The only divisors are λ_i + λ_j, so one λ may be 0 or slightly negative and Λ may be spread
/// wide. U is orthogonal for every C. Iterates with CayleySweep while that converges fast, else
/// with Newton's method, Aᵀδ + δA = −F with A = Λ + ½K(I + C). At the solution spec(A) = spec(UΛ),
/// so the branch that starts at the identity lasts while Re(w_i + w_j) > 0 for i < j.
template <class Scalar>
class CayleyN {
 public:
  using State = Accumulator<Matrix<Scalar>>;
  using Wide = Extended<Scalar>;

  CayleyN(const Vector<Scalar>& lambda, Scalar h);

  Matrix<Scalar>& C() { return C_; }

  /// Sets C = hΩ/2, which is correct to second order.
  void start(const Matrix<Scalar>& K);

  /// Iterates the fixed point from the current C. Returns false if it converges slowly. K = hM.
  bool fixed_point(const Matrix<Scalar>& K);

  /// Iterates Newton's method from the current C. Returns false unless it ends on the principal
  /// branch. K = hM.
  bool newton(const Matrix<Scalar>& K);

  /// Sets M ← UᵀMU = M + (4/h)[Λ, D], D = C²(I − C²)⁻¹, with C accurate to the last bit, and
  /// Q ← QU = Q + Q(U − I), U − I = 2(I + C)C(I − C²)⁻¹, where x has a Q. When it is stopped, x is
  /// unchanged.
  void transport(State& x);

  /// Returns U − I of the last transport.
  const Matrix<Scalar>& U_minus_I() const { return U_minus_I_; }

 private:
  /// Makes further sweeps in wider arithmetic, until the error of C is far below its rounding.
  void refine();
  void residual(const Matrix<Scalar>& K);
  void linearise(const Matrix<Scalar>& K);

  Scalar h_;
  Vector<Scalar> lambda_;
  Lyapunov<Scalar> lyapunov_;
  CayleySweep<Scalar> sweep_;
  CayleySweep<Wide> wide_sweep_;
  Matrix<Scalar> C_, A_, F_, G_, delta_, U_minus_I_, hOmega_;
  Matrix<Wide> wide_C_, wide_hOmega_;
};

template <class Scalar>
CayleyN<Scalar>::CayleyN(const Vector<Scalar>& lambda, Scalar h)
    : h_(h),
      lambda_(lambda),
      lyapunov_(lambda.size()),
      sweep_(lambda),
      wide_sweep_(lambda.template cast<Wide>()) {
  const Eigen::Index N = lambda.size();
  for (auto* A : {&C_, &A_, &F_, &G_, &delta_, &U_minus_I_, &hOmega_}) A->setZero(N, N);
  for (auto* A : {&wide_C_, &wide_hOmega_}) A->setZero(N, N);
}

template <class Scalar>
void CayleyN<Scalar>::start(const Matrix<Scalar>& K) {
  inverse_inertia(lambda_, K, Scalar(2), hOmega_);
  C_ = hOmega_ / 2;
}

template <class Scalar>
bool CayleyN<Scalar>::fixed_point(const Matrix<Scalar>& K) {
  const Scalar enough = two_to<Scalar>(1 - bits<Scalar>), slow = Scalar(0.5);
  constexpr int most = 60;
  Scalar last = std::numeric_limits<Scalar>::infinity();
  inverse_inertia(lambda_, K, Scalar(2), hOmega_);
  for (int k = 0; k < most; ++k) {
    const Scalar size = sweep_(hOmega_, C_);
    const Scalar ratio = k == 0 ? slow : size / last;
    // The scale is the angle of U, which stays bounded however large C is.
    const Scalar angle = std::min<Scalar>(1, C_.cwiseAbs().maxCoeff());
    if (!(size <= last * slow) && k > 1) return size <= 16 * enough * angle;
    if (size * ratio <= enough * angle) return true;
    last = size;
  }
  return false;
}

template <class Scalar>
bool CayleyN<Scalar>::newton(const Matrix<Scalar>& K) {
  const Scalar enough = two_to<Scalar>(-(bits<Scalar> + 1) / 2);
  using std::isfinite;
  constexpr int most = 20;
  for (int k = 0; k < most; ++k) {
    stop_point(2 * static_cast<double>(C_.rows() * C_.size()));
    residual(K);
    if (!F_.allFinite()) return false;
    linearise(K);
    lyapunov_.solve(F_, delta_);
    delta_ = ((delta_ - delta_.transpose()) / 2).eval();
    C_ -= delta_;
    const Scalar size = delta_.cwiseAbs().maxCoeff();
    if (!isfinite(size)) return false;
    if (size <= enough * C_.cwiseAbs().maxCoeff()) {
      linearise(K);
      return lyapunov_.smallest_pair_sum() > 0;
    }
  }
  return false;
}

template <class Scalar>
void CayleyN<Scalar>::transport(State& x) {
  const Eigen::Index N = C_.rows(), top = x.value.rows() - N;
  const Vector<Wide>& lambda = wide_sweep_.lambda();
  for (Eigen::Index j = 0; j < N; ++j)
    for (Eigen::Index i = 0; i < N; ++i)
      wide_hOmega_(i, j) = i == j ? Wide(0) : h_ * x.extended(top + i, j) / (lambda(i) + lambda(j));
  refine();
  U_minus_I_ = wide_sweep_.U_minus_I().template cast<Scalar>();
  if (top > 0) {
    stop_point(static_cast<double>(C_.rows() * C_.size()));
    G_.noalias() = x.value.topRows(N) * U_minus_I_;
  }
  const Matrix<Wide>& D = wide_sweep_.D();
  for (Eigen::Index j = 0; j < N; ++j)
    for (Eigen::Index i = 0; i < j; ++i) {
      x.add(top + i, j, 4 * (lambda(i) - lambda(j)) * D(i, j) / h_);
      x.mirror(top + i, j, top + j, i);
    }
  if (top > 0)
    for (Eigen::Index j = 0; j < N; ++j)
      for (Eigen::Index i = 0; i < N; ++i) x.add_scalar(i, j, G_(i, j));
}

template <class Scalar>
void CayleyN<Scalar>::refine() {
  const Wide enough = two_to<Wide>(-bits<Scalar> - 11);
  constexpr int most = 12;
  wide_C_ = C_.template cast<Wide>();
  Wide last = std::numeric_limits<Wide>::infinity();
  for (int k = 0; k < most; ++k) {
    const Wide size = wide_sweep_(wide_hOmega_, wide_C_);
    if (!(size > enough * wide_C_.cwiseAbs().maxCoeff() && 2 * size < last)) break;
    last = size;
  }
  wide_sweep_.evaluate(wide_C_);
}

template <class Scalar>
void CayleyN<Scalar>::residual(const Matrix<Scalar>& K) {
  G_ = K;
  G_.noalias() += K * C_;
  F_ = Scalar(-0.5) * G_;
  F_.noalias() += Scalar(0.5) * C_ * G_;
  F_ += lambda_.asDiagonal() * C_ + C_ * lambda_.asDiagonal();
}

template <class Scalar>
void CayleyN<Scalar>::linearise(const Matrix<Scalar>& K) {
  A_ = Scalar(0.5) * K;
  A_.noalias() += Scalar(0.5) * K * C_;
  A_.diagonal() += lambda_;
  lyapunov_.factor(A_);
}

// Compiled once, in j_d_n.cc.
extern template class CayleyN<double>;

}  // namespace stiefel
