#pragma once

#include <cmath>
#include <memory>

#include "engine/linalg/cayley_n.h"
#include "engine/linalg/history.h"
#include "engine/linalg/split_product.h"

namespace stiefel {

/// U = J_D⁻¹(hM), that is UΛ − ΛUᵀ = hM, in N dimensions, in the deviation X = UΛ − Λ = T + hM/2 with
/// T symmetric ([RB] (7.13), (7.14), where S = Λ + T):
///
///     WᵀW = Λ², W = Λ + X   ⟺   ΛT + TΛ = −(h/2)[Λ, M] − XᵀX,
///
/// by the fixed point T ← …/(λ_i + λ_j), one symmetric product a sweep, started from the extrapolated
/// T of the last steps. Small quantities stay relatively accurate. Any symmetric T satisfies
/// UΛ − ΛUᵀ = hM, so what is watched is Λ⁻¹(WᵀW − Λ²)Λ⁻¹ = UᵀU − I. Where the sweeps are slow, Newton in
/// Cayley's form takes over; where Λ is spread wide or not positive, Cayley's form from the start.
template <class Scalar, Arithmetic arithmetic>
class JDInverseN {
 public:
  using Point = Matrix<Scalar>;
  using State = Accumulator<Point, arithmetic>;
  using Memory = History<Scalar>;
  using Wide = Extended<Scalar>;

  JDInverseN(const Vector<Scalar>& lambda, Scalar h)
      : lambda_(lambda), wide_lambda_(lambda.template cast<Wide>()), h_(h), N_(lambda.size()),
        wide_spread_(!(lambda.minCoeff() * widest_ > lambda.maxCoeff())), cayley_(lambda),
        split_(N_), T_(Matrix<Scalar>::Zero(N_, N_)), X_(T_), G_(T_), low_(T_), K_(T_), change_(T_) {}

  /// Finds U; false where the branch from the identity has none.
  bool solve(const State& x, const Memory& memory) {
    if (!wide_spread_) {
      set_K(x, h_);
      if (!memory.predict(T_)) T_.setZero();
      if (sweep()) return true;
      begin_cayley();
      if (!cayley_.newton(K_)) return false;
      T_from_cayley();
      return true;
    }
    set_K(x, h_);
    if (!memory.predict(cayley_.C())) begin_cayley();
    if (cayley_.fixed_point(K_)) return true;
    begin_cayley();
    return cayley_.newton(K_);
  }

  /// The same for the step t·h, from the solution found last.
  bool continue_to(const State& x, double t) {
    set_K(x, static_cast<Scalar>(t) * h_);
    low_ = cayley_.C();
    if (cayley_.newton(K_)) {
      if (!wide_spread_ && t == 1) T_from_cayley();
      return true;
    }
    cayley_.C() = low_;
    return false;
  }
  void restart() { cayley_.C().setZero(); }

  /// Q ← QU = Q + QXΛ⁻¹, M ← UᵀMU = M + (1/h)(λ_i − λ_j)(X_ij/λ_j + X_ji/λ_i).
  void transport(State& x, Memory& memory) {
    if (wide_spread_) return transport_cayley(x, memory);
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
        mirror(x, top, i, j);
      }
    if (top > 0) {
      G_.noalias() = x.value.topRows(N_) * X_;
      add_to_frame(x, G_.array().rowwise() / lambda_.transpose().array());
    }
    memory.push(T_);
  }

 private:
  static constexpr Scalar widest_ = 64;  ///< spread of Λ up to which the deviation form is accurate

  void set_K(const State& x, Scalar h) { K_ = h * x.value.bottomRows(N_); }

  /// Sweeps until UᵀU − I is at rounding level; false if that is slow.
  bool sweep() {
    constexpr Scalar unit = 0x1p-53, slow = Scalar(0.7);
    constexpr int most = 40;
    Scalar last = std::numeric_limits<Scalar>::infinity();
    for (int k = 0; k < most; ++k) {
      X_ = T_ + K_ / 2;
      G_.template triangularView<Eigen::Upper>().setZero();
      G_.template selfadjointView<Eigen::Upper>().rankUpdate(X_.transpose());
      Scalar defect = 0, size = 0;
      for (Eigen::Index j = 0; j < N_; ++j)
        for (Eigen::Index i = 0; i <= j; ++i) {
          const Scalar sum = lambda_(i) + lambda_(j);
          const Scalar T = -((lambda_(i) - lambda_(j)) * (K_(i, j) / 2) + G_(i, j)) / sum;
          const Scalar inverse = 1 / (lambda_(i) * lambda_(j));
          defect = std::max(defect, std::abs(T - T_(i, j)) * sum * inverse);
          size = std::max(size, std::max(std::abs(X_(i, j)), std::abs(X_(j, i))) *
                                    std::max(lambda_(i), lambda_(j)) * inverse);
          T_(i, j) = T_(j, i) = T;
        }
      if (!std::isfinite(size) || size > 1) return false;
      const Scalar ratio = k == 0 ? size : defect / last;
      // The wider sweep that follows in compensated arithmetic needs T, which is as X², to its last bit.
      const Scalar enough = arithmetic == Arithmetic::compensated ? size * size : size;
      if (defect * ratio <= unit * enough) {
        X_ = T_ + K_ / 2;
        return true;
      }
      if (k > 0 && ratio > slow) return defect <= 64 * unit * size && (X_ = T_ + K_ / 2, true);
      last = defect;
    }
    return false;
  }

  /// X = T + hM/2, M with its carry, as a rounded X and what that took away; then XᵀX = high + low.
  void form_residual(const State& x) {
    const Eigen::Index top = x.value.rows() - N_;
    for (Eigen::Index j = 0; j < N_; ++j)
      for (Eigen::Index i = 0; i < N_; ++i) {
        const Wide exact = T_(i, j) + Wide(h_) * x.extended(top + i, j) / 2;
        X_(i, j) = static_cast<Scalar>(exact);
        change_(i, j) = static_cast<Scalar>(exact - X_(i, j));
      }
    split_(X_, change_, G_, low_);
  }

  /// More sweeps for the price of a product each: as T changes by δ, XᵀX changes by Xᵀδ + δX. Until T
  /// is known far below its rounding, because what is left is a drift that grows like the steps.
  void correct_residual(const State& x) {
    constexpr Scalar negligible = 0x1p-66;
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
          K_(i, j) = K_(j, i) = change - change_(i, j);
          change_(i, j) = change;
          largest = std::max(largest, std::abs(K_(i, j)));
        }
      if (largest <= negligible * size) return;
      low_.noalias() += X_.transpose() * K_;
    }
  }

  /// T_ij = −((h/2)[Λ, M]_ij + (XᵀX)_ij) / (λ_i + λ_j).
  Wide wide_T(Eigen::Index i, Eigen::Index j, Wide commutator) const {
    return -(commutator + G_(i, j) + (Wide(low_(i, j)) + low_(j, i))) /
           (wide_lambda_(i) + wide_lambda_(j));
  }

  /// C = hΩ/2.
  void begin_cayley() {
    for (Eigen::Index j = 0; j < N_; ++j) {
      cayley_.C()(j, j) = 0;
      for (Eigen::Index i = 0; i < j; ++i) {
        cayley_.C()(i, j) = K_(i, j) / (2 * (lambda_(i) + lambda_(j)));
        cayley_.C()(j, i) = -cayley_.C()(i, j);
      }
    }
  }

  void T_from_cayley() {
    cayley_.deviation(X_);
    T_ = (X_ + X_.transpose()) / 2;
    X_ = T_ + K_ / 2;
  }

  void transport_cayley(State& x, Memory& memory) {
    const Eigen::Index top = x.value.rows() - N_;
    wide_K_.resize(N_, N_);
    for (Eigen::Index j = 0; j < N_; ++j)
      for (Eigen::Index i = 0; i < N_; ++i) wide_K_(i, j) = h_ * x.extended(top + i, j);
    cayley_.increments(wide_K_, wide_E_, wide_D_);
    for (Eigen::Index j = 0; j < N_; ++j)
      for (Eigen::Index i = 0; i < j; ++i) {
        x.add(top + i, j, 4 * (wide_lambda_(i) - wide_lambda_(j)) * wide_D_(i, j) / h_);
        mirror(x, top, i, j);
      }
    if (top > 0) {
      G_.noalias() = x.value.topRows(N_) * wide_E_.template cast<Scalar>();
      add_to_frame(x, G_.array());
    }
    memory.push(cayley_.C());
  }

  /// M_ji = −M_ij, carry included.
  static void mirror(State& x, Eigen::Index top, Eigen::Index i, Eigen::Index j) {
    x.value(top + j, i) = -x.value(top + i, j);
    if constexpr (State::compensated) x.carry(top + j, i) = -x.carry(top + i, j);
  }

  template <class Increment>
  void add_to_frame(State& x, const Eigen::ArrayBase<Increment>& increment) const {
    for (Eigen::Index j = 0; j < N_; ++j)
      for (Eigen::Index i = 0; i < N_; ++i) x.add_scalar(i, j, increment(i, j));
  }

  Vector<Scalar> lambda_;
  Vector<Wide> wide_lambda_;
  Scalar h_;
  Eigen::Index N_;
  bool wide_spread_;
  CayleyN<Scalar> cayley_;
  SplitProduct<Scalar> split_;
  Matrix<Scalar> T_, X_, G_, low_, K_, change_;
  Matrix<Wide> wide_K_, wide_E_, wide_D_;
};

// Compiled once, in j_d_n.cc.
extern template class JDInverseN<double, Arithmetic::compensated>;
extern template class JDInverseN<double, Arithmetic::plain>;

}  // namespace stiefel
