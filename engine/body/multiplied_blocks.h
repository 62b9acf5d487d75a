#pragma once

#include "engine/body/j_d/j_d_n.h"
#include "engine/body/principal_branch.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"

namespace stiefel {

/// A rigid body whose blocks, Q over P, a group multiplies from the right, ẋ = xξ: rotations, or
/// all invertible matrices. P belongs to εM ([RB] Prop. 3.13). `Derived` has generator(x, ξ).
template <class Derived, class Scalar_, MatrixKind kind>
class MultipliedBlocks {
 public:
  using Scalar = Scalar_;
  using State = Matrix<Scalar>;
  using Algebra = Matrix<Scalar>;

  MultipliedBlocks(Vector<Scalar> lambda, Scalar epsilon)
      : lambda_(std::move(lambda)),
        epsilon_(epsilon),
        D_(zero()),
        xi_(D_),
        exponential_(lambda_.size(), kind) {}

  const Vector<Scalar>& lambda() const { return lambda_; }
  Scalar epsilon() const { return epsilon_; }

  void field(const State& x, State& dx) {
    static_cast<Derived&>(*this).generator(x, xi_);
    dx.noalias() = x * xi_;
  }
  Algebra zero() const { return Algebra::Zero(lambda_.size(), lambda_.size()); }
  static void bracket(const Algebra& a, const Algebra& b, Algebra& c) {
    c.noalias() = a * b;
    if constexpr (kind == MatrixKind::skew)
      subtract_transpose(c);
    else
      c.noalias() -= b * a;
  }
  void displacement(const State& x, const Algebra& theta, State& dx) {
    exponential_(theta, D_);
    dx.noalias() = x * D_;
  }

 protected:
  Vector<Scalar> lambda_;
  Scalar epsilon_;
  Algebra D_;  ///< workspace

 private:
  Algebra xi_;
  Exponential<Scalar> exponential_;
};

/// The discrete rigid body in blocks that U = J_D⁻¹(hM) multiplies from the right, x ← xU: a state
/// does not hold M, which follows from it at every step. `Derived` has form_momentum(x, M), and may
/// have `growth`, a diagonal D: x ← x(U + D).
template <class Derived>
class DiscreteBlocks {
 public:
  using Scalar = double;
  using Point = Eigen::MatrixXd;

  using State = StateWithMemory<Point, JDInverseN::Memory>;

  DiscreteBlocks(const Eigen::VectorXd& lambda, double h, Arithmetic arithmetic)
      : N_(lambda.size()),
        arithmetic_(arithmetic),
        branch_(lambda, h),
        M_(Point::Zero(N_, N_), arithmetic) {}

  State start(const Point& x) const {
    return {Accumulator<Point>(x, arithmetic_), branch_.memory()};
  }

  RunStatus step(State& state) {
    const Point& x = state.x.value;
    form_momentum(x);
    if (!M_.value.allFinite()) return {Outcome::not_finite, std::nullopt};
    if (M_.compensated) M_.carry.setZero();
    const RunStatus status = branch_.solve(M_, state.memory);
    if (!status.reached()) return status;
    branch_.inverse().transport(M_, state.memory);
    moved_.noalias() = x * branch_.inverse().U_minus_I();
    if constexpr (requires(Derived d) { d.growth; }) moved_ += x * derived().growth.asDiagonal();
    state.x.add(moved_);
    return {};
  }

  std::optional<double> largest_step(const State& state, double limit) {
    form_momentum(state.x.value);
    return branch_.largest_step(M_, limit);
  }

 protected:
  Eigen::Index N_;

 private:
  Derived& derived() { return static_cast<Derived&>(*this); }
  void form_momentum(const Point& x) {
    derived().form_momentum(x, M_.value);
    subtract_transpose(M_.value);
  }

  Arithmetic arithmetic_;
  PrincipalBranch<JDInverseN> branch_;
  Accumulator<Point> M_;
  Point moved_;
};

}  // namespace stiefel
