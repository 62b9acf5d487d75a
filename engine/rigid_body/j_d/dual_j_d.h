#pragma once

#include <Eigen/LU>

#include "engine/linalg/lie/so_n.h"
#include "engine/numbers/dual.h"
#include "engine/rigid_body/j_d/cayley_3.h"
#include "engine/rigid_body/j_d/j_d_n.h"

namespace stiefel {

/// The discrete rigid body's equation in dual numbers: with F(c) = c − (1 + |c|²) n − …, c′ =
/// −F_c⁻¹ F′, F′ at constant c.
template <class Real, int lanes>
class CayleyEquation3<Dual<Real, lanes>> {
 public:
  using Scalar = Dual<Real, lanes>;
  using Vec = Vector3<Scalar>;

  Vec c = Vec::Zero();

  bool solve(const Vec& n, const Vec& kappa) {
    return values_.solve(values_of(n), values_of(kappa)) && differentiate(n, kappa);
  }
  bool newton(const Vec& n, const Vec& kappa) {
    values_.c = values_of(c);
    return values_.newton(values_of(n), values_of(kappa)) && differentiate(n, kappa);
  }
  Vec correction(const Vec& r) const {
    Vec out = values_.correction(values_of(r)).template cast<Scalar>();
    for (int k = 0; k < lanes; ++k) set_lane(out, k, values_.correction(lane_of(r, k)));
    return out;
  }

 private:
  bool differentiate(const Vec& n, const Vec& kappa) {
    // One more round of Newton's method leaves c and gives the derivative of F at c.
    if (!values_.newton(values_of(n), values_of(kappa))) return false;
    c = values_.c.template cast<Scalar>();
    const Vec F = c - n - squared_norm(c) * n - kappa.cwiseProduct(cyclic_product<Scalar>(c, c));
    for (int k = 0; k < lanes; ++k) set_lane(c, k, -values_.correction(lane_of(F, k)));
    return true;
  }

  CayleyEquation3<Real> values_;
};

/// U = J_D⁻¹(hM) in dual numbers. The values of U are those of JDInverseN; with U′ = Uυ, υ skew,
///
///     UυΛ + ΛυUᵀ = −F′,   F = UΛ − ΛUᵀ − hM, F′ at constant U,
///
/// a linear system for the elements υ_ij, i < j, of small bodies, and Aᵀυ + υA = −UᵀF′U, A = ΛU, of
/// others.
template <class Real, int lanes>
class JDInverseN<Dual<Real, lanes>> {
 public:
  using Scalar = Dual<Real, lanes>;
  using State = Accumulator<Matrix<Scalar>>;

  using Memory = typename JDInverseN<Real>::Memory;

  JDInverseN(const Vector<Scalar>& lambda, Scalar h)
      : h_(h),
        N_(lambda.size()),
        lambda_(lambda),
        values_(values_of(lambda), h.value),
        lyapunov_(N_),
        D_(N_, N_),
        moved_(0, 0),
        product_(N_, N_) {}

  Memory memory() const { return values_.memory(); }

  bool solve(const State& x, const Memory& memory) {
    momentum_.value = values_of(Matrix<Scalar>(x.value.bottomRows(N_)));
    return values_.solve(momentum_, memory);
  }
  bool continue_to(const State& x, double t) {
    momentum_.value = values_of(Matrix<Scalar>(x.value.bottomRows(N_)));
    return values_.continue_to(momentum_, t);
  }
  void restart() { values_.restart(); }

  void transport(State& x, Memory& memory) {
    values_.transport(momentum_, memory);
    differentiate(x);
    moved_ = x.value * D_;
    product_.noalias() = D_.transpose() * moved_.bottomRows(N_);
    moved_.bottomRows(N_) += product_ / Real(2);
    subtract_transpose(moved_.bottomRows(N_));
    x.add(moved_);
  }

  const Matrix<Scalar>& U_minus_I() const { return D_; }

 private:
  void differentiate(const State& x) {
    D_ = values_.U_minus_I().template cast<Scalar>();
    Matrix<Real> U = values_.U_minus_I();
    U.diagonal().array() += Real(1);
    const Matrix<Scalar> W = U.template cast<Scalar>() * lambda_.asDiagonal();
    const Matrix<Scalar> F = W - W.transpose() - h_ * Matrix<Scalar>(x.value.bottomRows(N_));
    if (N_ <= largest_dense) {
      solve_by_elements(U, F);
    } else {
      lyapunov_.factor(values_of(lambda_).asDiagonal() * U);
      for (int k = 0; k < lanes; ++k) {
        Matrix<Real> upsilon = -(U.transpose() * lane_of(F, k) * U);
        lyapunov_.solve(upsilon, upsilon);
        set_lane(D_, k, U * (upsilon - upsilon.transpose()) / 2);
      }
    }
  }

  void solve_by_elements(const Matrix<Real>& U, const Matrix<Scalar>& F) {
    const Eigen::Index size = N_ * (N_ - 1) / 2;
    const auto at = [](Eigen::Index i, Eigen::Index j) { return j * (j - 1) / 2 + i; };  // i < j
    Matrix<Real> L = Matrix<Real>::Zero(size, size), right(size, lanes);
    const auto add = [&](Eigen::Index row, Eigen::Index k, Eigen::Index l, Real value) {
      if (k < l) L(row, at(k, l)) += value;
      if (k > l) L(row, at(l, k)) -= value;
    };
    for (Eigen::Index j = 0; j < N_; ++j)
      for (Eigen::Index i = 0; i < j; ++i) {
        const Eigen::Index row = at(i, j);
        for (Eigen::Index k = 0; k < N_; ++k) {
          add(row, k, j, U(i, k) * lambda_(j).value);  // (UυΛ)_ij
          add(row, i, k, U(j, k) * lambda_(i).value);  // (ΛυUᵀ)_ij
        }
        for (int lane = 0; lane < lanes; ++lane) right(row, lane) = -F(i, j).d[lane];
      }
    stop_point(static_cast<double>(size * size * size) / 3);
    const Matrix<Real> found = Eigen::PartialPivLU<Matrix<Real>>(L).solve(right);
    Matrix<Real> upsilon = Matrix<Real>::Zero(N_, N_);
    for (int lane = 0; lane < lanes; ++lane) {
      for (Eigen::Index j = 0; j < N_; ++j)
        for (Eigen::Index i = 0; i < j; ++i) {
          upsilon(i, j) = found(at(i, j), lane);
          upsilon(j, i) = -upsilon(i, j);
        }
      set_lane(D_, lane, U * upsilon);
    }
  }

  /// Up to this N the elements are solved for directly: 45 of them.
  static constexpr Eigen::Index largest_dense = 10;

  Scalar h_;
  Eigen::Index N_;
  Vector<Scalar> lambda_;
  JDInverseN<Real> values_;
  Accumulator<Matrix<Real>> momentum_{Matrix<Real>::Zero(N_, N_), Arithmetic::plain};
  Lyapunov<Real> lyapunov_;
  Matrix<Scalar> D_, moved_, product_;
};

}  // namespace stiefel
