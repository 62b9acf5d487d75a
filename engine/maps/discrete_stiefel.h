#pragma once

#include <Eigen/LU>

#include "engine/linalg/compensated.h"
#include "engine/linalg/lyapunov.h"
#include "engine/maps/map.h"

namespace stiefel {

/// The discrete variational problem of Moser and Veselov on V(n, N), [ST] (55):
///
///     Q_{k+1}Λ + Q_{k−1}Λ = B_kQ_k,   B_k = B_kᵀ,   Q_{k+1}Q_{k+1}ᵀ = I_n.
///
/// X = B_k⁻¹ solves CX + XCᵀ = G, C = Q_kΛ⁻¹Q_{k−1}ᵀ, G = Q_kΛ⁻²Q_kᵀ. It keeps m_k (57) and the
/// spectrum of L(μ) (61) exactly.
///
/// For n < N this is an integrable map of its own (at n = 1 the discrete Neumann system), NOT a
/// discretisation of the geodesic flow: its action differs from the geodesic's by a potential of
/// size 1/h². Started from two frames h apart on a geodesic it leaves it at once, whatever h.
/// For the geodesic flow take RattleStiefel. At n = N the two agree.
///
/// A state is Q_{k−1} over Q_k, 2n × N; every λ_i > 0. solver_stalled where the equation for X is
/// singular, or X is: there is no step size that could be made smaller.
template <class Scalar_, Arithmetic arithmetic>
class DiscreteStiefel {
 public:
  using Scalar = Scalar_;
  using Point = Matrix<Scalar>;

  struct State {
    Accumulator<Point, arithmetic> x;

    template <class Visitor>
    void each(Visitor&& visit) {
      x.each(visit);
    }
  };

  DiscreteStiefel(const Vector<Scalar>& lambda, Eigen::Index n)
      : lambda_(lambda),
        n_(n),
        lyapunov_(n),
        lu_(n),
        bar_(n, lambda.size()),
        I_(Matrix<Scalar>::Identity(n, n)),
        C_T_(n, n),
        G_(n, n),
        E_(n, n),
        X_(n, n),
        B_(n, n),
        next_(n) {}

  State start(const Point& x) const { return {Accumulator<Point, arithmetic>(x)}; }

  Ending step(State& state) {
    if (!state.x.value.allFinite()) return {Outcome::not_finite, std::nullopt};
    if (!find_B(state.x.value)) return {Outcome::solver_stalled, std::nullopt};
    keep_momentum(state.x.value.bottomRows(n_));
    for (Eigen::Index j = 0; j < state.x.value.cols(); ++j) {
      for (Eigen::Index i = 0; i < n_; ++i) {
        Wide sum = 0;
        for (Eigen::Index k = 0; k < n_; ++k) sum += B_(i, k) * state.x.extended(n_ + k, j);
        next_(i) = sum / lambda_(j) - state.x.extended(i, j);
      }
      for (Eigen::Index i = 0; i < n_; ++i) {
        set(state.x, i, j, state.x.extended(n_ + i, j));
        set(state.x, n_ + i, j, next_(i));
      }
    }
    return {};
  }

  std::optional<double> largest_step(const State&, double) const { return std::nullopt; }

 private:
  using Wide = Extended<Scalar>;

  /// B with CX + XCᵀ = G + X(Q_{k−1}Q_{k−1}ᵀ − I)X: the last term is rounding, and without it
  /// Q_{k+1} would inherit it from Q_{k−1}.
  bool find_B(const Point& x) {
    const auto Q_prev = x.topRows(n_), Q = x.bottomRows(n_);
    bar_ = Q * lambda_.cwiseInverse().asDiagonal();
    G_.noalias() = bar_ * bar_.transpose();
    C_T_.noalias() = Q_prev * bar_.transpose();
    E_.noalias() = Q_prev * Q_prev.transpose();
    E_ -= I_;
    if (n_ == 1) {
      B_(0, 0) = 2 * C_T_(0, 0) / G_(0, 0);
      if (B_(0, 0) != Scalar(0)) B_(0, 0) -= E_(0, 0) / C_T_(0, 0);
      return true;
    }
    lyapunov_.factor(C_T_);
    lyapunov_.solve(G_, X_);
    B_.noalias() = X_ * E_;
    G_.noalias() += B_ * X_;
    lyapunov_.solve(G_, X_);
    G_ = (X_ + X_.transpose()) / 2;
    if (!G_.allFinite()) return false;
    lu_.compute(G_);
    X_ = lu_.solve(I_);
    B_ = (X_ + X_.transpose()) / 2;
    return B_.allFinite();
  }

  /// B ← B(QQᵀ)⁻¹, to first order in the rounding of Q: m_{k+1} − m_k = BQQᵀ − QQᵀBᵀ.
  template <class Frame>
  void keep_momentum(const Frame& Q) {
    E_.noalias() = Q * Q.transpose();
    E_ -= I_;
    G_.noalias() = B_ * E_;
    B_ -= G_;
  }

  static void set(Accumulator<Point, arithmetic>& x, Eigen::Index i, Eigen::Index j, Wide value) {
    x.value(i, j) = static_cast<Scalar>(value);
    if constexpr (arithmetic == Arithmetic::compensated)
      x.carry(i, j) = static_cast<Scalar>(value - x.value(i, j));
  }

  Vector<Scalar> lambda_;
  Eigen::Index n_;
  Lyapunov<Scalar> lyapunov_;
  Eigen::PartialPivLU<Matrix<Scalar>> lu_;
  Matrix<Scalar> bar_, I_, C_T_, G_, E_, X_, B_;
  Vector<Wide> next_;
};

}  // namespace stiefel
