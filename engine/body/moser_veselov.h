#pragma once

#include "engine/body/j_d/cayley_n.h"
#include "engine/body/j_d/discrete_body_3.h"
#include "engine/body/j_d/discrete_body_4.h"
#include "engine/body/j_d/j_d_n.h"
#include "engine/body/principal_branch.h"
#include "engine/dense/so_n.h"

namespace stiefel {

/// Solves UΛ − ΛUᵀ = hM for U = J_D⁻¹(hM) in three dimensions and applies the step, with the
/// interface of JDInverseN.
template <class Scalar, bool frame>
class JDInverse3 {
 public:
  using Body = DiscreteBody3<Scalar, frame>;
  using Point = typename Body::Point;
  using State = typename Body::State;
  using Memory = NoMemory;

  JDInverse3(const Vector<Scalar>& lambda, Scalar h, bool moves_frame = true)
      : inertia_(PrincipalMoments3<Extended<Scalar>>(lambda), h), body_(moves_frame) {}

  Memory memory(const auto&) const { return {}; }

  bool solve(const State& x, const Memory&) { return body_.solve(x, inertia_); }
  /// Finds U for the step t·h, starting from the solution found last.
  bool continue_to(const State& x, double t) {
    return body_.continue_to(x, inertia_, static_cast<Scalar>(t));
  }
  /// Forgets the last solution: the next `continue_to` starts from t = 0.
  void restart() { body_.restart(); }

  /// Sets Q ← QU, M ← UᵀMU.
  void transport(State& x, Memory&) const { body_.transport(x, inertia_); }

 private:
  DiscreteInertia3<Scalar> inertia_;
  Body body_;
};

/// Solves UΛ − ΛUᵀ = hM for U = J_D⁻¹(hM) in four dimensions and applies the step, with the
/// interface of JDInverseN. Long steps, and Λ with a λ < 0, use the general solver CayleyN.
template <class Scalar, bool frame>
class JDInverse4 {
 public:
  using Body = DiscreteBody4<Scalar, frame>;
  using State = typename Body::State;
  using Memory = NoMemory;

  JDInverse4(const Vector<Scalar>& lambda, Scalar h, bool moves_frame = true)
      : inertia_(PairSums4<Extended<Scalar>>(lambda), h),
        h_(h),
        body_(moves_frame),
        cayley_(lambda, h),
        K_(Matrix<Scalar>::Zero(4, 4)),
        found_(K_) {}

  Memory memory(const auto&) const { return {}; }

  bool solve(const State& x, const Memory&) {
    if (body_.solve_where_easy(x, inertia_)) return true;
    form_K(x, h_);
    if (!K_.allFinite()) return false;
    cayley_.start(K_);
    if (cayley_.fixed_point(K_)) return take_over();
    cayley_.start(K_);
    return cayley_.newton(K_) && take_over();
  }
  /// Finds U for the step t·h, starting from the solution found last, or from U = I after
  /// `restart`.
  bool continue_to(const State& x, double t) {
    form_K(x, static_cast<Scalar>(t) * h_);
    found_ = cayley_.C();
    if (cayley_.newton(K_)) return take_over();
    cayley_.C() = found_;
    return false;
  }
  void restart() { cayley_.C().setZero(); }

  /// Sets Q ← QU, M ← UᵀMU.
  void transport(State& x, Memory&) const { body_.transport(x, inertia_); }

 private:
  void form_K(const State& x, Scalar h) {
    for (int k = 0; k < 6; ++k) {
      const int i = skew4_rows[k], j = skew4_columns[k];
      K_(i, j) = h * x.value(So4<Scalar, frame>::first + k);
      K_(j, i) = -K_(i, j);
    }
  }
  bool take_over() {
    Skew4<Scalar> c;
    for (int k = 0; k < 6; ++k) c(k) = cayley_.C()(skew4_rows[k], skew4_columns[k]);
    body_.set(c);
    return true;
  }

  DiscreteInertia4<Scalar> inertia_;
  Scalar h_;
  Body body_;
  CayleyN<Scalar> cayley_;
  Matrix<Scalar> K_, found_;
};

template <class Space>
struct JDInverseOf;
template <class Scalar, bool frame>
struct JDInverseOf<So3<Scalar, frame>> {
  using type = JDInverse3<Scalar, frame>;
};
template <class Scalar, bool frame>
struct JDInverseOf<So4<Scalar, frame>> {
  using type = JDInverse4<Scalar, frame>;
};
template <>
struct JDInverseOf<SoN<double>> {
  using type = JDInverseN;
};

/// The Moser–Veselov step on (Q, M), [RB] (4.5) = (MDRBn), with physical momentum M and step h:
///
///     U = J_D⁻¹(hM),   J_D(U) = UΛ − ΛUᵀ,
///     Q_{k+1} = Q_k U,
///     M_{k+1} = Uᵀ M_k U,
///
/// U is the solution on the branch that starts at the identity. For every N, and every h for which
/// U exists, the step keeps QMQᵀ, the eigenvalues of M, every Manakov coefficient, and hence the
/// energy exactly. Order 2 in Q, time-symmetric. Ends with left_domain where there is no U. The
/// memory of another `JDInverse` may depend on the start.
template <class Space, class JDInverse = typename JDInverseOf<Space>::type>
class MoserVeselov {
 public:
  using Scalar = typename Space::Scalar;
  using Point = typename Space::State;
  static constexpr bool only_rotates = true;
  static constexpr bool stops_before_change() { return true; }

  using State = StateWithMemory<Point, typename JDInverse::Memory>;

  /// `more` are further arguments of JDInverse: in three and four dimensions whether the scene has
  /// a Q.
  template <class... More>
  MoserVeselov(const Vector<Scalar>& lambda, Scalar h,
               Arithmetic arithmetic = Arithmetic::compensated, More... more)
      : arithmetic_(arithmetic), branch_(lambda, h, more...) {}

  State start(const Point& x) const {
    return {Accumulator<Point>(x, arithmetic_), branch_.memory(x)};
  }

  RunStatus step(State& state) {
    const RunStatus status = branch_.solve(state.x, state.memory);
    if (status.reached()) branch_.inverse().transport(state.x, state.memory);
    return status;
  }

  /// Returns the largest |h| up to `limit` for which a step from `state` exists, to 1e-3.
  std::optional<double> largest_step(const State& state, double limit) {
    return branch_.largest_step(state.x, limit);
  }

 private:
  Arithmetic arithmetic_;
  PrincipalBranch<JDInverse> branch_;
};

}  // namespace stiefel
