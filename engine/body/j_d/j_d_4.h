#pragma once

#include "engine/body/j_d/cayley_n.h"
#include "engine/body/j_d/discrete_body_4.h"
#include "engine/body/principal_branch.h"

namespace stiefel {

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

}  // namespace stiefel
