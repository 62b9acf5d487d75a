#pragma once

#include <cmath>

#include "engine/dense/continuation.h"
#include "engine/dense/decompositions.h"
#include "engine/frame/blocked_pass.h"
#include "engine/methods/method.h"

namespace stiefel {

/// The variational step of the geodesic flow on V(n, N), 1 ≤ n ≤ N, from the discrete Lagrangian
/// ½‖(Q_{k+1} − Q_k)Λ^{1/2}‖²/h: RATTLE (Andersen 1983) for the constraint QQᵀ = I_n,
///
///     S_½ = S + (h/2)BQ,   Q′ = Q + hS_½Λ⁻¹,   Q′Q′ᵀ = I,
///     S′ = S_½ + (h/2)B′Q′,   Q′Λ⁻¹S′ᵀ + S′Λ⁻¹Q′ᵀ = 0.
///
/// With Y = (h²/2)B, V = SΛ⁻¹, D = Q + hV and G = QΛ⁻¹, ConstraintRiccati finds Y from
///
///     DDᵀ − I = h²VVᵀ + h(QVᵀ + VQᵀ) + (QQᵀ − I);
///
/// with X = Q′ − Q = hV + YG, K′ = Q′Λ⁻¹Q′ᵀ,
///
///     K′Y′ + Y′K′ = −(XXᵀ + Q′Q′ᵀ − QQᵀ).
///
/// QQᵀ − I is the measured rounding error of Q. No term of size 1 is subtracted from another, and S
/// keeps its digits at every h‖V‖. The repair of QQᵀ − I adds ∓O((QQᵀ − I)/h)Q to S in the two
/// halves of the step, which cancel but for the rounding of each. A step therefore repairs at most
/// most_repair·h‖V‖: the rounding stays below that of S, and a state at rest does not move.
///
/// These n × n matrices follow from the moments of the state, so a step is one pass over its
/// columns: O(Nn² + n³). The map keeps QQᵀ = I and m = SQᵀ − QSᵀ exactly, is symplectic,
/// time-symmetric and of order 2. At n = N it is the Moser–Veselov map with M = QᵀS − SᵀQ. Needs
/// every λ_i > 0. Ends with left_domain where there is no Y on the principal branch. ‖Q̇‖ varies up
/// to √(2E/λ_min), so a step size that is safe at the start may fail later. The energy oscillates
/// by (h²/24) tr(BKB), K = QΛ⁻¹Qᵀ, while (h‖Q̇‖)² λ_max/λ_min stays well below 1. With longer steps
/// and chaotic motion it drifts.
///
/// Internally Λ is divided by a power of two that makes the largest λ about 1, and h by the same
/// number: the step depends only on the ratio Λ : h, and products of two λ then never overflow.
///
/// State: Q over S, 2n × N.
template <class Scalar_>
class RattleStiefel {
 public:
  using Scalar = Scalar_;
  using Point = Matrix<Scalar>;
  /// The multipliers are found before the pass changes the state.
  static constexpr bool stops_before_change() { return true; }

  struct State {
    Accumulator<Point> x;
    FrameMoments<Scalar> moments;
    Matrix<Scalar> half_B;  ///< B′/2 of the last step, from which the next solve starts
    [[no_unique_address]] NoMemory memory = {};

    template <class Visitor>
    void each(Visitor&& visit) {
      x.each(visit);
      moments.each(visit);
      visit(half_B);
    }
    /// Returns |Q|² + |Q̇|².
    Scalar squared_norm() const { return moments.QQ[0].trace() + moments.VV[0].trace(); }
  };

  RattleStiefel(const Vector<Scalar>& lambda, Eigen::Index n, Scalar h,
                Arithmetic arithmetic = Arithmetic::compensated)
      : arithmetic_(arithmetic),
        h_(h),
        unit_(binary_unit<Scalar>(lambda.maxCoeff())),
        n_(n),
        inverse_(Vector<Scalar>::Zero(lambda.size() + FramePass<Scalar>::width)),
        pass_(arithmetic, n, lambda.size()),
        riccati_(n),
        lyapunov_(n) {
    inverse_.head(lambda.size()) = (lambda / unit_).cwiseInverse();
  }

  State start(const Point& x) {
    State state{Accumulator<Point>(x, arithmetic_), FrameMoments<Scalar>(n_),
                Matrix<Scalar>::Zero(n_, n_)};
    pass_.advance(columns(state), 0, nullptr, nullptr, state.moments);
    return state;
  }
  /// Sets a state to x, but for the multiplier from which the next solve starts.
  void restart(State& state, const Point& x) {
    state.x.value = x;
    if (state.x.compensated) state.x.carry.setZero();
    pass_.advance(columns(state), 0, nullptr, nullptr, state.moments);
  }

  RunStatus step(State& state) { return step(state, h_); }

  /// Makes a step of size h. The stages of a composition differ in h and share one state.
  RunStatus step(State& state, Scalar h) {
    const RunStatus status = find_multipliers(state, h);
    if (status.reached()) advance(state, h);
    return status;
  }
  /// The two halves of a step: finds the multipliers, and moves the columns by them.
  RunStatus find_multipliers(State& state, Scalar h);
  void advance(State& state, Scalar h) {
    pass_.advance(columns(state), h / unit_, Y_.data(), Y1_.data(), state.moments);
  }

  /// Return K′, Y/h and Y′/h of the last multipliers, Λ and h being divided by the unit of Λ.
  const Matrix<Scalar>& K1() const { return A_; }
  const Matrix<Scalar>& B() const { return Y_; }
  const Matrix<Scalar>& Z() const { return Y1_; }

  /// Returns the largest |h| up to `limit` for which a step from `state` exists, to 1e-3.
  std::optional<double> largest_step(const State& state, double limit);

 private:
  FrameColumns<Scalar> columns(State& state) const {
    return {state.x.value.data(), state.x.carry_data(), inverse_.data(), state.x.value.cols()};
  }

  /// Finds Y for the step h, starting from the current Y: A = GDᵀ, P = GGᵀ, E = DDᵀ − I.
  bool solve(const FrameMoments<Scalar>& at, Scalar h);

  /// Sets defect_ to QQᵀ − I. What may be rounding is reduced where necessary to most_repair·h‖V‖
  /// in its largest element.
  void find_defect(const FrameMoments<Scalar>& at, Scalar h);

  double follow(const FrameMoments<Scalar>& at, Scalar h, double end);

  /// Sets A_ = K′ = QΛ⁻¹Qᵀ + QΛ⁻¹Xᵀ + XΛ⁻¹Qᵀ + XΛ⁻¹Xᵀ, and finds Y′ from it and the right-hand
  /// side defect_ − XXᵀ.
  void find_Y1(const FrameMoments<Scalar>& at, Scalar h);

  /// Adds XΛ⁻ᵖXᵀ = h² VΛ⁻ᵖVᵀ + h(YGΛ⁻ᵖVᵀ + VΛ⁻ᵖGᵀY) + YGΛ⁻ᵖGᵀY.
  void add_XX(const Matrix<Scalar>& VV, const Matrix<Scalar>& GV, const Matrix<Scalar>& GG,
              Scalar h, Matrix<Scalar>& sum);

  /// In plain arithmetic Q itself loses up to u in each step, whatever h‖V‖ is.
  Scalar most_repair() const { return Scalar(arithmetic_ == Arithmetic::plain ? 1 : 0x1p-10); }

  Arithmetic arithmetic_;
  Scalar h_, unit_;  ///< unit_ is the number by which Λ and h are divided
  Eigen::Index n_;
  Vector<Scalar> inverse_;  ///< Λ⁻¹, followed by zeros
  BlockedPass<Scalar> pass_;
  ConstraintRiccati<Scalar> riccati_;
  SymmetricLyapunov<Scalar> lyapunov_;
  Matrix<Scalar> A_{n_, n_}, E_{A_}, defect_{A_}, Y_{A_}, Y1_{A_}, found_{A_}, product_{A_};
};

template <class Scalar>
RunStatus RattleStiefel<Scalar>::find_multipliers(State& state, Scalar h) {
  using std::abs;
  const double size = static_cast<double>(abs(h));
  h /= unit_;
  if (!state.moments.finite()) return {Outcome::not_finite, std::nullopt};
  Y_ = (h * h) * state.half_B;
  if (!solve(state.moments, h)) {
    const double reached = follow(state.moments, h, 1);
    if (reached == 0) return {Outcome::solver_stalled, std::nullopt};
    if (reached < 1) return {Outcome::left_domain, reached * size};
  }
  find_Y1(state.moments, h);
  state.half_B = Y1_ / (h * h);
  Y_ /= h;
  Y1_ /= h;
  return {};
}

template <class Scalar>
std::optional<double> RattleStiefel<Scalar>::largest_step(const State& state, double limit) {
  using std::abs;
  const double size = static_cast<double>(abs(h_));
  return follow(state.moments, h_ / unit_, limit / size) * size;
}

template <class Scalar>
bool RattleStiefel<Scalar>::solve(const FrameMoments<Scalar>& at, Scalar h) {
  find_defect(at, h);
  A_ = at.QQ[1] + h * at.QV[1];
  E_ = h * (h * at.VV[0] + (at.QV[0] + at.QV[0].transpose())) + defect_;
  return riccati_.solve(A_, at.QQ[2], E_, Y_);
}

template <class Scalar>
void RattleStiefel<Scalar>::find_defect(const FrameMoments<Scalar>& at, Scalar h) {
  using std::abs;
  using std::sqrt;
  defect_ = at.QQ[0];
  defect_.diagonal().array() -= Scalar(1);
  const Scalar size = defect_.cwiseAbs().maxCoeff(),
               most = most_repair() * abs(h) * sqrt(at.VV[0].trace());
  const Scalar rounding = sqrt(std::numeric_limits<Scalar>::epsilon());
  if (size > most && size < rounding) defect_ *= most / size;
}

template <class Scalar>
double RattleStiefel<Scalar>::follow(const FrameMoments<Scalar>& at, Scalar h, double end) {
  Y_.setZero();
  return continuation(end, [&](double t) {
    found_ = Y_;
    if (solve(at, static_cast<Scalar>(t) * h)) return true;
    Y_ = found_;
    return false;
  });
}

template <class Scalar>
void RattleStiefel<Scalar>::find_Y1(const FrameMoments<Scalar>& at, Scalar h) {
  product_ = h * at.QV[1];
  product_.noalias() += at.QQ[2] * Y_;
  A_ = at.QQ[1] + product_ + product_.transpose();
  add_XX(at.VV[1], at.QV[2], at.QQ[3], h, A_);
  lyapunov_.factor(A_);

  E_ = -defect_;
  add_XX(at.VV[0], at.QV[1], at.QQ[2], h, E_);
  E_ = -E_;
  lyapunov_.solve(E_, product_);
  Y1_ = (product_ + product_.transpose()) / 2;
}

template <class Scalar>
void RattleStiefel<Scalar>::add_XX(const Matrix<Scalar>& VV, const Matrix<Scalar>& GV,
                                   const Matrix<Scalar>& GG, Scalar h, Matrix<Scalar>& sum) {
  product_ = h * GV;
  product_.noalias() += Scalar(0.5) * (GG * Y_);
  found_.noalias() = Y_ * product_;
  sum += (h * h) * VV + found_ + found_.transpose();
}

// Compiled once, in stiefel.cc.
extern template class RattleStiefel<double>;

}  // namespace stiefel
