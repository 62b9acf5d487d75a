#pragma once

#include "engine/frames/passes/rattle_stiefel.h"
#include "engine/linalg/matrix_equations/dual_equations.h"

namespace stiefel {

/// The RATTLE step in dual numbers, from the same equations. Its two constraint solves follow the
/// implicit function theorem (ConstraintRiccati, SymmetricLyapunov). With Y = (h²/2)B, V = SΛ⁻¹,
/// G = QΛ⁻¹ and D = Q + hV,
///
///     Q′ = D + YG,   V_½ = V + YG/h,   S_½ = S + YQ/h,
///     K′Y′ + Y′K′ = −h(Q′V_½ᵀ + V_½Q′ᵀ),   S′ = S_½ + Y′Q′/h.
template <class Real, int lanes>
class RattleStiefel<Dual<Real, lanes>> {
 public:
  using Scalar = Dual<Real, lanes>;
  using Point = Matrix<Scalar>;

  struct State {
    Accumulator<Point> x;

    template <class Visitor>
    void each(Visitor&& visit) {
      x.each(visit);
    }
  };

  RattleStiefel(const Vector<Scalar>& lambda, Eigen::Index n, Scalar h,
                Arithmetic arithmetic = Arithmetic::compensated, LowerBlock lower = LowerBlock::S)
      : arithmetic_(arithmetic),
        lower_(lower),
        h_(h),
        n_(n),
        inverse_(lambda.cwiseInverse()),
        riccati_(n),
        lyapunov_(n),
        A_(n, n),
        P_(n, n),
        E_(n, n),
        Y_(n, n) {}

  State start(const Point& x) const { return {Accumulator<Point>(x, arithmetic_)}; }

  RunStatus step(State& state) {
    const auto Q = state.x.value.topRows(n_), lower = state.x.value.bottomRows(n_);
    V_ = lower_ == LowerBlock::S ? Point(lower * inverse_.asDiagonal()) : Point(lower);
    G_ = Q * inverse_.asDiagonal();
    D_ = Q + h_ * V_;
    stop_point(3 * static_cast<double>(n_ * Q.size()));
    A_.noalias() = G_ * D_.transpose();
    P_.noalias() = G_ * G_.transpose();
    E_.noalias() = D_ * D_.transpose();
    E_.diagonal().array() -= Scalar(1);
    Y_.setZero();
    if (!riccati_.solve(A_, P_, E_, Y_)) return {Outcome::left_domain, std::nullopt};

    increment_.resize(2 * n_, Q.cols());
    Y_over_h_ = Y_ / h_;
    G_ = (Y_over_h_ * G_).eval();
    increment_.topRows(n_) = h_ * (V_ + G_);
    V_ += G_;
    D_ = Q + increment_.topRows(n_);
    G_ = D_ * inverse_.asDiagonal();
    stop_point(3 * static_cast<double>(n_ * Q.size()));
    P_.noalias() = G_ * D_.transpose();
    E_.noalias() = D_ * V_.transpose();
    E_ = (-h_ * (E_ + E_.transpose())).eval();
    lyapunov_.factor(P_);
    lyapunov_.solve(E_, Y_);
    Y_ /= h_;
    if (lower_ == LowerBlock::S) {
      increment_.bottomRows(n_).noalias() = Y_over_h_ * Q;
      increment_.bottomRows(n_).noalias() += Y_ * D_;
    } else {
      increment_.bottomRows(n_) = V_ - lower;
      increment_.bottomRows(n_).noalias() += Y_ * G_;
    }
    state.x.add(increment_);
    return {};
  }

  std::optional<double> largest_step(const State&, double) const { return std::nullopt; }

 private:
  Arithmetic arithmetic_;
  LowerBlock lower_;
  Scalar h_;
  Eigen::Index n_;
  Vector<Scalar> inverse_;  ///< Λ⁻¹
  ConstraintRiccati<Scalar> riccati_;
  SymmetricLyapunov<Scalar> lyapunov_;
  Matrix<Scalar> A_, P_, E_, Y_, Y_over_h_;
  Point V_, G_, D_, increment_;
};

}  // namespace stiefel
