#pragma once

#include "engine/dense/decompositions.h"
#include "engine/methods/method.h"
#include "stiefel/stop.h"

namespace stiefel {

/// The discrete variational problem of Moser and Veselov on V(n, N), [ST] (55):
///
///     Q_{k+1}Λ + Q_{k−1}Λ = B_kQ_k,   B_k = B_kᵀ,   Q_{k+1}Q_{k+1}ᵀ = I_n.
///
/// X = B_k⁻¹ solves CX + XCᵀ = G, C = Q_kΛ⁻¹Q_{k−1}ᵀ, G = Q_kΛ⁻²Q_kᵀ. The map keeps m_k (57) and
/// the spectrum of L(μ) (61) exactly.
///
/// For n < N this is an integrable map of its own (at n = 1 the discrete Neumann system), NOT a
/// discretisation of the geodesic flow: its action differs from the geodesic's by a potential of
/// size 1/h². Started from two frames h apart on a geodesic it leaves the geodesic at once, for
/// every h. RattleStiefel approximates the geodesic flow. At n = N the two maps are the same.
///
/// A state is Q_{k−1} over Q_k, 2n × N; every λ_i > 0. Ends with solver_stalled where X or its
/// equation is singular: the map has no step size that could be reduced.
template <class Scalar_>
class DiscreteStiefel {
 public:
  using Scalar = Scalar_;
  using Point = Matrix<Scalar>;

  using State = PlainState<Point>;

  DiscreteStiefel(const Vector<Scalar>& lambda, Eigen::Index n)
      : lambda_(lambda.template cast<Wide>()), n_(n), lyapunov_(n), lu_(n) {}

  State start(const Point& x) const { return {Accumulator<Point>(x, Arithmetic::compensated)}; }

  RunStatus step(State& state) {
    if (!state.x.value.allFinite()) return {Outcome::not_finite, std::nullopt};
    if (!find_B(state.x)) return {Outcome::solver_stalled, std::nullopt};
    multiply(bar_, B_, Q_);
    for (Eigen::Index j = 0; j < Q_.cols(); ++j)
      for (Eigen::Index i = 0; i < n_; ++i) {
        set(state.x, i, j, Q_(i, j));
        set(state.x, n_ + i, j, bar_(i, j) / lambda_(j) - Q_prev_(i, j));
      }
    return {};
  }

  std::optional<double> largest_step(const State&, double) const { return std::nullopt; }

 private:
  using Wide = Extended<Scalar>;

  /// Finds B with CX + XCᵀ = G + X(Q_{k−1}Q_{k−1}ᵀ − I)X; the last term removes the rounding errors
  /// of Q_{k−1}, which Q_{k+1} would inherit. The step uses B(QQᵀ)⁻¹Q_k in place of BQ_k, so this
  /// function returns B as B(2I − QQᵀ): m changes by BQQᵀ − QQᵀBᵀ, and the rounding errors in
  /// Q_kQ_kᵀ − I then do not change m.
  bool find_B(const Accumulator<Point>& x) {
    for (Eigen::Index j = 0; j < Q_.cols(); ++j)
      for (Eigen::Index i = 0; i < n_; ++i) {
        Q_prev_(i, j) = static_cast<Wide>(x.extended(i, j));
        Q_(i, j) = static_cast<Wide>(x.extended(n_ + i, j));
      }
    inverse_.noalias() = Wide(-1) * Q_ * Q_.transpose();
    inverse_.diagonal().array() += Wide(2);
    bar_ = Q_ * lambda_.cwiseInverse().asDiagonal();
    multiply(X_, bar_, bar_.transpose());
    multiply(B_, inverse_, X_);
    multiply(G_, B_, inverse_);
    multiply(X_, Q_prev_, bar_.transpose());
    multiply(C_T_, X_, inverse_);
    multiply(E_, Q_prev_, Q_prev_.transpose());
    E_ -= I_;
    if (!(n_ == 1 ? find_scalar() : find_matrix())) return false;
    multiply(G_, B_, inverse_);
    B_.swap(G_);
    return B_.allFinite();
  }

  void multiply(auto& out, const auto& A, const auto& B) const {
    stop_point(static_cast<double>(n_ * Q_.size()));
    out.noalias() = A * B;
  }

  bool find_scalar() {
    const Wide C = C_T_(0, 0), E = E_(0, 0);
    B_(0, 0) = 2 * C / G_(0, 0);
    if (E <= C * C && -E <= C * C && C != Wide(0)) B_(0, 0) -= E / (2 * C);
    return true;
  }

  bool find_matrix() {
    lyapunov_.factor(C_T_);
    lyapunov_.solve(G_, X_);
    B_.noalias() = X_ * E_;
    G_.noalias() += B_ * X_;
    lyapunov_.solve(G_, X_);
    G_ = (X_ + X_.transpose()) / 2;
    if (!G_.allFinite()) return false;
    lu_.factor(G_);
    lu_.solve(I_, X_);
    B_ = (X_ + X_.transpose()) / 2;
    return true;
  }

  static void set(Accumulator<Point>& x, Eigen::Index i, Eigen::Index j, Wide value) {
    x.value(i, j) = static_cast<Scalar>(value);
    x.carry(i, j) = static_cast<Scalar>(value - x.value(i, j));
  }

  Vector<Wide> lambda_;
  Eigen::Index n_;
  Lyapunov<Wide> lyapunov_;
  Lu<Wide> lu_;
  Matrix<Wide> Q_prev_{n_, lambda_.size()}, Q_{Q_prev_}, bar_{Q_prev_};
  Matrix<Wide> I_{Matrix<Wide>::Identity(n_, n_)}, inverse_{I_}, C_T_{I_}, G_{I_}, E_{I_}, X_{I_},
      B_{I_};
};

}  // namespace stiefel
