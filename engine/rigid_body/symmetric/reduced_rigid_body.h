#pragma once

#include "engine/linalg/matrix_equations/inertia_operator.h"
#include "engine/methods/support/moved_by.h"
#include "engine/numbers/stoppable_product.h"

namespace stiefel {

/// The reduced symmetric representation [RB] (8.2),
///
///     Q̇ = QΩ,   Ω = J⁻¹(Qᵀ(A − Aᵀ)Q)/ε,
///
/// A = PQᵀ is a constant of the motion, so the system holds A, and P = AQ is computed for output
/// only. M = Qᵀ(A − Aᵀ)Q/ε. The motion keeps every invariant of the rigid body; the Manakov
/// integrals have the form tr((A − Aᵀ + μQΛ²Qᵀ)^k), (8.3). State: Q, N × N. SO(N) acts from the
/// right.
template <class Scalar_>
class ReducedRigidBody : public MovedBy<ReducedRigidBody<Scalar_>, RightMultiplication<Scalar_>> {
  using Base = MovedBy<ReducedRigidBody, RightMultiplication<Scalar_>>;
  using Base::lambda_;

 public:
  static constexpr const char* name = "reduced_rigid_body";
  using typename Base::Algebra;
  using typename Base::Scalar;
  using typename Base::State;

  ReducedRigidBody(Vector<Scalar> lambda, Matrix<Scalar> A, Scalar epsilon = 1)
      : Base(std::move(lambda)),
        A_(std::move(A)),
        epsilon_(epsilon),
        G_(Base::zero()),
        product_(G_) {}

  const Matrix<Scalar>& A() const { return A_; }
  Scalar epsilon() const { return epsilon_; }
  Matrix<Scalar> P(const State& Q) const { return A_ * Q; }

  void generator(const State& x, Algebra& Omega) {
    stoppable_product(A_, x, product_);
    stoppable_product(x.transpose(), product_, G_);
    inverse_inertia(lambda_, G_, epsilon_, Omega);
  }

 private:
  Matrix<Scalar> A_;
  Scalar epsilon_;
  Algebra G_, product_;
};

}  // namespace stiefel
