#pragma once

#include <algorithm>
#include <cmath>

#include "engine/linalg/compensated.h"
#include "engine/linalg/split_product.h"

namespace stiefel {

/// U = J_D⁻¹(hM) in N dimensions as the deviation X = UΛ − Λ = T + hM/2 with T symmetric ([RB]
/// (7.13), (7.14), where S = Λ + T): with W = Λ + X,
///
///     WᵀW = Λ²   ⟺   ΛT + TΛ = −(h/2)[Λ, M] − XᵀX,
///
/// by the fixed point T ← …/(λ_i + λ_j), one symmetric product a sweep. Small quantities stay
/// relatively accurate. Any symmetric T satisfies UΛ − ΛUᵀ = hM, so what is watched is Λ⁻¹(WᵀW −
/// Λ²)Λ⁻¹ = UᵀU − I. For λ_i > 0 of moderate spread.
template <class Scalar, Arithmetic arithmetic>
class DeviationN {
 public:
  using State = Accumulator<Matrix<Scalar>, arithmetic>;
  using Wide = Extended<Scalar>;

  DeviationN(const Vector<Scalar>& lambda, Scalar h);

  Matrix<Scalar>& T() { return T_; }

  /// From the T that is there until UᵀU − I is at rounding level; false if that is slow. K = hM.
  bool sweep(const Matrix<Scalar>& K);

  /// Takes X from elsewhere.
  void set(const Matrix<Scalar>& X, const Matrix<Scalar>& K);

  /// M ← UᵀMU = M + (1/h)(λ_i − λ_j)(X_ij/λ_j + X_ji/λ_i), and X to its last bit.
  void transport_momentum(State& x);

  /// U − I = XΛ⁻¹ of the last transport_momentum.
  const Matrix<Scalar>& U_minus_I();

  /// Q ← QU = Q + QXΛ⁻¹.
  void transport_frame(State& x);

 private:
  /// X = T + hM/2, M with its carry, as a rounded X and what that took away; then XᵀX = high + low.
  void form_residual(const State& x);

  /// More sweeps for the price of a product each: as T changes by δ, XᵀX changes by Xᵀδ + δX. Until
  /// T is known far below its rounding, because what is left is a drift that grows like the steps.
  void correct_residual(const State& x);

  /// T_ij = −((h/2)[Λ, M]_ij + (XᵀX)_ij) / (λ_i + λ_j).
  Wide wide_T(Eigen::Index i, Eigen::Index j, Wide commutator) const {
    return -(commutator + G_(i, j) + (Wide(low_(i, j)) + low_(j, i))) /
           (wide_lambda_(i) + wide_lambda_(j));
  }

  Vector<Scalar> lambda_;
  Vector<Wide> wide_lambda_;
  Scalar h_;
  Eigen::Index N_;
  SplitProduct<Scalar> split_;
  Matrix<Scalar> T_, X_, G_, low_, change_, step_change_;
};

template <class Scalar, Arithmetic arithmetic>
DeviationN<Scalar, arithmetic>::DeviationN(const Vector<Scalar>& lambda, Scalar h)
    : lambda_(lambda),
      wide_lambda_(lambda.template cast<Wide>()),
      h_(h),
      N_(lambda.size()),
      split_(N_),
      T_(Matrix<Scalar>::Zero(N_, N_)),
      X_(T_),
      G_(T_),
      low_(T_),
      change_(T_),
      step_change_(T_) {}

template <class Scalar, Arithmetic arithmetic>
bool DeviationN<Scalar, arithmetic>::sweep(const Matrix<Scalar>& K) {
  const Scalar unit = two_to<Scalar>(-bits<Scalar>), slow = Scalar(0.7);
  constexpr int most = 40;
  using std::abs, std::isfinite;
  Scalar last = std::numeric_limits<Scalar>::infinity();
  for (int k = 0; k < most; ++k) {
    X_ = T_ + K / 2;
    G_.template triangularView<Eigen::Upper>().setZero();
    G_.template selfadjointView<Eigen::Upper>().rankUpdate(X_.transpose());
    Scalar defect = 0, size = 0;
    for (Eigen::Index j = 0; j < N_; ++j)
      for (Eigen::Index i = 0; i <= j; ++i) {
        const Scalar sum = lambda_(i) + lambda_(j);
        const Scalar T = -((lambda_(i) - lambda_(j)) * (K(i, j) / 2) + G_(i, j)) / sum;
        const Scalar inverse = 1 / (lambda_(i) * lambda_(j));
        defect = std::max<Scalar>(defect, abs(T - T_(i, j)) * sum * inverse);
        size = std::max<Scalar>(size, std::max<Scalar>(abs(X_(i, j)), abs(X_(j, i))) *
                                          std::max(lambda_(i), lambda_(j)) * inverse);
        T_(i, j) = T_(j, i) = T;
      }
    if (!isfinite(size) || size > 1) return false;
    // Compensated arithmetic goes on from here and wants T, which is as X², to its last bit.
    const Scalar enough = arithmetic == Arithmetic::compensated ? size * size : size;
    const Scalar ratio = k == 0 ? slow : defect / last;
    if (defect * ratio <= unit * enough || (k > 0 && ratio > slow && defect <= 64 * unit * size)) {
      X_ = T_ + K / 2;
      return true;
    }
    if (k > 0 && ratio > slow) return false;
    last = defect;
  }
  return false;
}

template <class Scalar, Arithmetic arithmetic>
void DeviationN<Scalar, arithmetic>::set(const Matrix<Scalar>& X, const Matrix<Scalar>& K) {
  T_ = (X + X.transpose()) / 2;
  X_ = T_ + K / 2;
}

template <class Scalar, Arithmetic arithmetic>
void DeviationN<Scalar, arithmetic>::transport_momentum(State& x) {
  constexpr bool refine = arithmetic == Arithmetic::compensated;
  const Eigen::Index top = x.value.rows() - N_;
  if (refine) {
    form_residual(x);
    correct_residual(x);
  }
  for (Eigen::Index j = 0; j < N_; ++j)
    for (Eigen::Index i = 0; i <= j; ++i) {
      const Wide difference = wide_lambda_(i) - wide_lambda_(j);
      const Wide half = Wide(h_) * x.extended(top + i, j) / 2;
      const Wide T = refine ? wide_T(i, j, difference * half) : Wide(T_(i, j));
      const Wide X_ij = T + half, X_ji = T - half;
      T_(i, j) = T_(j, i) = static_cast<Scalar>(T);
      X_(i, j) = static_cast<Scalar>(X_ij);
      X_(j, i) = static_cast<Scalar>(X_ji);
      if (i == j) continue;
      x.add(top + i, j, difference * (X_ij / wide_lambda_(j) + X_ji / wide_lambda_(i)) / h_);
      x.mirror(top + i, j, top + j, i);
    }
}

template <class Scalar, Arithmetic arithmetic>
const Matrix<Scalar>& DeviationN<Scalar, arithmetic>::U_minus_I() {
  for (Eigen::Index j = 0; j < N_; ++j) change_.col(j) = X_.col(j) / lambda_(j);
  return change_;
}

template <class Scalar, Arithmetic arithmetic>
void DeviationN<Scalar, arithmetic>::transport_frame(State& x) {
  G_.noalias() = x.value.topRows(N_) * X_;
  for (Eigen::Index j = 0; j < N_; ++j)
    for (Eigen::Index i = 0; i < N_; ++i) x.add_scalar(i, j, G_(i, j) / lambda_(j));
}

template <class Scalar, Arithmetic arithmetic>
void DeviationN<Scalar, arithmetic>::form_residual(const State& x) {
  const Eigen::Index top = x.value.rows() - N_;
  for (Eigen::Index j = 0; j < N_; ++j)
    for (Eigen::Index i = 0; i < N_; ++i) {
      const Wide exact = T_(i, j) + Wide(h_) * x.extended(top + i, j) / 2;
      X_(i, j) = static_cast<Scalar>(exact);
      change_(i, j) = static_cast<Scalar>(exact - X_(i, j));
    }
  split_(X_, change_, G_, low_);
}

template <class Scalar, Arithmetic arithmetic>
void DeviationN<Scalar, arithmetic>::correct_residual(const State& x) {
  const Scalar negligible = two_to<Scalar>(-bits<Scalar> - 13);
  using std::abs;
  constexpr int most = 4;
  const Eigen::Index top = x.value.rows() - N_;
  const Scalar size = X_.cwiseAbs().maxCoeff();
  change_.setZero();
  for (int k = 0; k < most; ++k) {
    Scalar largest = 0;
    for (Eigen::Index j = 0; j < N_; ++j)
      for (Eigen::Index i = 0; i <= j; ++i) {
        const Wide difference = wide_lambda_(i) - wide_lambda_(j);
        const Wide T = wide_T(i, j, difference * (Wide(h_) * x.extended(top + i, j) / 2));
        const Scalar change = static_cast<Scalar>(T - T_(i, j));
        step_change_(i, j) = step_change_(j, i) = change - change_(i, j);
        change_(i, j) = change;
        largest = std::max<Scalar>(largest, abs(step_change_(i, j)));
      }
    if (largest <= negligible * size) return;
    low_.noalias() += X_.transpose() * step_change_;
  }
}

// Compiled once, in deviation_n.cc.
extern template class DeviationN<double, Arithmetic::compensated>;
extern template class DeviationN<double, Arithmetic::plain>;

}  // namespace stiefel
