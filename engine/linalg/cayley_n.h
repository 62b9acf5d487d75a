#pragma once

#include <Eigen/Cholesky>
#include <cmath>

#include "engine/linalg/compensated.h"
#include "engine/linalg/lu.h"
#include "engine/linalg/lyapunov.h"

namespace stiefel {

/// U = J_D⁻¹(K), K = hM, in N dimensions as the Cayley transform U = (I − C)⁻¹(I + C), C skew:
///
///     F(C) = ΛC + CΛ − ½ (I − C) K (I + C) = 0.
///
/// It divides by λ_i + λ_j only, so one λ may be 0 or slightly negative and Λ may be spread wide,
/// and U is orthogonal whatever C. Fixed point while that converges fast; else Newton, Aᵀδ + δA =
/// −F with A = Λ + ½K(I + C). At the solution spec(A) = spec(UΛ), so the branch that starts at the
/// identity lasts while Re(w_i + w_j) > 0 for i < j.
template <class Scalar, Arithmetic arithmetic>
class CayleyN {
 public:
  using State = Accumulator<Matrix<Scalar>, arithmetic>;
  using Wide = Extended<Scalar>;

  CayleyN(const Vector<Scalar>& lambda, Scalar h);

  Matrix<Scalar>& C() { return C_; }

  /// C = hΩ/2, which is right to second order.
  void start(const Matrix<Scalar>& K);

  /// From the C that is there; false if that is slow. K = hM.
  bool fixed_point(const Matrix<Scalar>& K);

  /// From the C that is there, to the principal branch or not at all.
  bool newton(const Matrix<Scalar>& K);

  /// UΛ − Λ = 2(I − C)⁻¹CΛ.
  const Matrix<Scalar>& deviation();

  /// M ← UᵀMU = M + (4/h)[Λ, D], D = C²(I − C²)⁻¹, after one more correction of C in wider
  /// arithmetic.
  void transport_momentum(State& x);

  /// U − I of the last transport_momentum.
  const Matrix<Scalar>& U_minus_I() const { return U_minus_I_; }

  /// Q ← QU = Q + Q(U − I), U − I = 2(I + C)C(I − C²)⁻¹.
  void transport_frame(State& x);

 private:
  /// C ← the skew part of F over λ_i + λ_j: a sweep of the fixed point.
  void correct(Matrix<Wide>& C, const Matrix<Wide>& F) const;

  void residual(const Matrix<Scalar>& K);

  void linearise(const Matrix<Scalar>& K);

  /// The skew part of F over λ_i + λ_j, and its largest element.
  Scalar divide_by_sums(Matrix<Scalar>& F) const;

  Scalar h_;
  Vector<Scalar> lambda_;
  Vector<Wide> wide_lambda_;
  Lyapunov<Scalar> lyapunov_;
  Matrix<Scalar> C_, A_, F_, G_, delta_, U_minus_I_;

  /// The last correction's workspace.
  struct WideWorkspace {
    explicit WideWorkspace(Eigen::Index N) : C(N, N), K(N, N), product(N, N), llt(N) {}
    Matrix<Wide> C, K, product;
    Eigen::LLT<Matrix<Wide>> llt;
  } wide_;
};

template <class Scalar, Arithmetic arithmetic>
CayleyN<Scalar, arithmetic>::CayleyN(const Vector<Scalar>& lambda, Scalar h)
    : h_(h),
      lambda_(lambda),
      wide_lambda_(lambda.template cast<Wide>()),
      lyapunov_(lambda.size()),
      C_(Matrix<Scalar>::Zero(lambda.size(), lambda.size())),
      A_(C_),
      F_(C_),
      G_(C_),
      delta_(C_),
      U_minus_I_(C_),
      wide_(lambda.size()) {}

template <class Scalar, Arithmetic arithmetic>
void CayleyN<Scalar, arithmetic>::start(const Matrix<Scalar>& K) {
  C_ = K;
  divide_by_sums(C_);
  C_ /= 2;
}

template <class Scalar, Arithmetic arithmetic>
bool CayleyN<Scalar, arithmetic>::fixed_point(const Matrix<Scalar>& K) {
  const Scalar enough = two_to<Scalar>(1 - bits<Scalar>), slow = Scalar(0.5);
  constexpr int most = 60;
  Scalar last = std::numeric_limits<Scalar>::infinity();
  for (int k = 0; k < most; ++k) {
    residual(K);
    const Scalar size = divide_by_sums(F_);
    C_ -= F_;
    const Scalar ratio = k == 0 ? slow : size / last;
    if (!(size <= last * slow) && k > 1) return size <= 16 * enough * C_.cwiseAbs().maxCoeff();
    if (size * ratio <= enough * C_.cwiseAbs().maxCoeff()) return true;
    last = size;
  }
  return false;
}

template <class Scalar, Arithmetic arithmetic>
bool CayleyN<Scalar, arithmetic>::newton(const Matrix<Scalar>& K) {
  const Scalar enough = two_to<Scalar>(-(bits<Scalar> + 1) / 2);
  using std::isfinite;
  constexpr int most = 20;
  for (int k = 0; k < most; ++k) {
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

template <class Scalar, Arithmetic arithmetic>
const Matrix<Scalar>& CayleyN<Scalar, arithmetic>::deviation() {
  G_ = Matrix<Scalar>::Identity(C_.rows(), C_.rows()) - C_;
  delta_ = Scalar(2) * (G_.partialPivLu().solve(C_) * lambda_.asDiagonal());
  return delta_;
}

template <class Scalar, Arithmetic arithmetic>
void CayleyN<Scalar, arithmetic>::transport_momentum(State& x) {
  const Eigen::Index N = C_.rows(), top = x.value.rows() - N;
  Matrix<Wide>&C = wide_.C, &K = wide_.K, &product = wide_.product;
  C = C_.template cast<Wide>();
  for (Eigen::Index j = 0; j < N; ++j)
    for (Eigen::Index i = 0; i < N; ++i) K(i, j) = h_ * x.extended(top + i, j) / 2;
  product.noalias() = K * C;
  product += K;  // ½K(I + C)
  K = product;
  K.noalias() -= C * product;
  correct(C, K);
  product.noalias() = Wide(-1) * C * C;
  product.diagonal().array() += Wide(1);
  wide_.llt.compute(product);
  Matrix<Wide>&quotient = product, &D = K;
  quotient = C;
  wide_.llt.solveInPlace(quotient);
  D.noalias() = C * quotient;
  U_minus_I_ = (Wide(2) * (quotient + D)).template cast<Scalar>();
  for (Eigen::Index j = 0; j < N; ++j)
    for (Eigen::Index i = 0; i < j; ++i) {
      x.add(top + i, j, 4 * (wide_lambda_(i) - wide_lambda_(j)) * D(i, j) / h_);
      x.mirror(top + i, j, top + j, i);
    }
}

template <class Scalar, Arithmetic arithmetic>
void CayleyN<Scalar, arithmetic>::transport_frame(State& x) {
  G_.noalias() = x.value.topRows(C_.rows()) * U_minus_I_;
  for (Eigen::Index j = 0; j < G_.cols(); ++j)
    for (Eigen::Index i = 0; i < G_.rows(); ++i) x.add_scalar(i, j, G_(i, j));
}

template <class Scalar, Arithmetic arithmetic>
void CayleyN<Scalar, arithmetic>::correct(Matrix<Wide>& C, const Matrix<Wide>& F) const {
  for (Eigen::Index j = 0; j < C.cols(); ++j)
    for (Eigen::Index i = 0; i < j; ++i) {
      C(i, j) = (F(i, j) - F(j, i)) / (2 * (wide_lambda_(i) + wide_lambda_(j)));
      C(j, i) = -C(i, j);
    }
}

template <class Scalar, Arithmetic arithmetic>
void CayleyN<Scalar, arithmetic>::residual(const Matrix<Scalar>& K) {
  G_ = K;
  G_.noalias() += K * C_;
  F_ = Scalar(-0.5) * G_;
  F_.noalias() += Scalar(0.5) * (C_ * G_);
  F_ += lambda_.asDiagonal() * C_ + C_ * lambda_.asDiagonal();
}

template <class Scalar, Arithmetic arithmetic>
void CayleyN<Scalar, arithmetic>::linearise(const Matrix<Scalar>& K) {
  A_ = Scalar(0.5) * K;
  A_.noalias() += Scalar(0.5) * (K * C_);
  A_.diagonal() += lambda_;
  lyapunov_.factor(A_);
}

template <class Scalar, Arithmetic arithmetic>
Scalar CayleyN<Scalar, arithmetic>::divide_by_sums(Matrix<Scalar>& F) const {
  using std::abs;
  Scalar largest = 0;
  for (Eigen::Index j = 0; j < F.cols(); ++j) {
    F(j, j) = 0;
    for (Eigen::Index i = 0; i < j; ++i) {
      F(i, j) = (F(i, j) - F(j, i)) / (2 * (lambda_(i) + lambda_(j)));
      F(j, i) = -F(i, j);
      largest = std::max<Scalar>(largest, abs(F(i, j)));
    }
  }
  return largest;
}

// Compiled once, in cayley_n.cc.
extern template class CayleyN<double, Arithmetic::compensated>;
extern template class CayleyN<double, Arithmetic::plain>;

}  // namespace stiefel
