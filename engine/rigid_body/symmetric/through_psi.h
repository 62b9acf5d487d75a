#pragma once

#include <optional>

#include "engine/linalg/lie/so_3.h"
#include "engine/linalg/lie/so_n.h"
#include "engine/methods/support/concepts.h"
#include "engine/numbers/compensated.h"
#include "engine/numbers/stoppable_product.h"
#include "engine/rigid_body/symmetric/scaling.h"
#include "engine/rigid_body/symmetric/symmetric_rigid_body.h"

namespace stiefel {

/// Reads Q and M from a state of the rigid body, and writes them. For a state without a frame Q is
/// I.
template <class Space>
struct FrameAndMomentum;

/// Coordinates of three dimensions. `set` keeps the sign of the quaternion. In a scene without a
/// frame q is 0.
template <class Scalar, bool frame>
struct FrameAndMomentum<So3<Scalar, frame>> {
  using Point = typename So3<Scalar, frame>::State;

  static Matrix<Scalar> Q(const Point& x) {
    if constexpr (frame)
      if (!x.template head<4>().isZero(0)) return rotation_matrix<Scalar>(x.template head<4>());
    return Matrix<Scalar>::Identity(3, 3);
  }
  static Matrix<Scalar> M(const Point& x) { return hat(x.template tail<3>()); }

  template <class Frame, class Momentum>
  static void set(Point& x, const Frame& Q, const Momentum& M) {
    if constexpr (frame) {
      if (x.template head<4>().isZero(0)) {
        x.template tail<3>() = vee(M);
        return;
      }
      const auto q = quaternion_of(Q);
      x.template head<4>() = q.dot(x.template head<4>()) < 0 ? (-q).eval() : q;
    }
    x.template tail<3>() = vee(M);
  }
};

template <class Scalar>
struct FrameAndMomentum<SoN<Scalar>> {
  using Point = Matrix<Scalar>;

  static Matrix<Scalar> Q(const Point& x) {
    if (x.rows() > x.cols()) return x.topRows(x.cols());
    return Matrix<Scalar>::Identity(x.cols(), x.cols());
  }
  static Matrix<Scalar> M(const Point& x) { return x.bottomRows(x.cols()); }

  template <class Frame, class Momentum>
  static void set(Point& x, const Frame& Q, const Momentum& M) {
    if (x.rows() > x.cols()) x.topRows(x.cols()) = Q;
    x.bottomRows(x.cols()) = M;
  }
};

/// Uses a map of the symmetric representation (Q, P) as a map of (Q, M): applies Ψ⁻¹ at the start,
/// with an ε for which ‖εM‖ is about 1, and Ψ after every step ([RB] Prop. 3.6, 3.11, 3.13). The
/// state is (Q, P); (Q, M) is computed from it.
template <class Space, class Inner>
class ThroughPsi {
 public:
  using Scalar = typename Space::Scalar;
  using Point = typename Space::State;

  struct State {
    Accumulator<Point> x;
    typename Inner::State symmetric;
    Vector<Scalar> epsilon;  ///< one number

    template <class Visitor>
    void each(Visitor&& visit) {
      x.each(visit);
      symmetric.each(visit);
      visit(epsilon);
    }
  };

  ThroughPsi(const Vector<Scalar>& lambda, Scalar h, Arithmetic arithmetic)
      : lambda_(lambda), h_(h), arithmetic_(arithmetic), M_(lambda.size(), lambda.size()) {}

  State start(const Point& x) {
    const Eigen::Index N = lambda_.size();
    const Matrix<Scalar> Q = Both::Q(x), M = Both::M(x);
    const Scalar epsilon = unit_epsilon(M);
    const auto P = Psi_inverse(Q, M, epsilon);
    Matrix<Scalar> QP(2 * N, N);
    QP << Q, P ? *P : M;  // where Ψ⁻¹ fails, M is not finite, and the first step reports it
    return {Accumulator<Point>(x, arithmetic_), inner(epsilon).start(QP),
            Vector<Scalar>::Constant(1, epsilon)};
  }

  RunStatus step(State& state) {
    const Scalar epsilon = state.epsilon(0);
    const RunStatus status = inner(epsilon).step(state.symmetric);
    if (!status.reached()) return status;
    const auto Q = state.symmetric.x.value.topRows(M_.rows());
    const auto P = state.symmetric.x.value.bottomRows(M_.rows());
    stoppable_product(Q.transpose(), P, QP_);
    M_ = (QP_ - QP_.transpose()) / epsilon;
    Both::set(state.x.value, Q, M_);
    return {};
  }

  std::optional<double> largest_step(const State& state, double limit) {
    return inner(state.epsilon(0)).largest_step(state.symmetric, limit);
  }

 private:
  using Both = FrameAndMomentum<Space>;

  Inner& inner(Scalar epsilon) {
    if (!inner_ || epsilon != epsilon_)
      inner_.emplace(SymmetricRigidBody<Scalar>(lambda_, epsilon), h_, arithmetic_);
    epsilon_ = epsilon;
    return *inner_;
  }

  Vector<Scalar> lambda_;
  Scalar h_, epsilon_ = 0;
  Arithmetic arithmetic_;
  std::optional<Inner> inner_;
  Matrix<Scalar> QP_, M_;
};

}  // namespace stiefel
