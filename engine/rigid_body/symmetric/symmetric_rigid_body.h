#pragma once

#include "engine/linalg/matrix_equations/inertia_operator.h"
#include "engine/methods/support/moved_by.h"
#include "engine/numbers/stoppable_product.h"

namespace stiefel {

/// The symmetric representation of the rigid body, left-invariant: [RB] (3.1) = (SRBn), with the
/// scaling of Prop. 3.13,
///
///     Q̇ = QΩ,   Ṗ = PΩ,   Ω = J⁻¹(M),   M = (QᵀP − PᵀQ)/ε.
///
/// On SO(N) × SO(N) it is the rigid body with ‖M‖_op ≤ 2/ε. The motion keeps PQᵀ, hence m = QMQᵀ =
/// (PQᵀ − QPᵀ)/ε, the energy and every other invariant of the rigid body. State: Q over P, 2N × N.
/// SO(N) acts from the right on both blocks.
template <class Scalar_>
class SymmetricRigidBody
    : public MovedBy<SymmetricRigidBody<Scalar_>, RightMultiplication<Scalar_>> {
  using Base = MovedBy<SymmetricRigidBody, RightMultiplication<Scalar_>>;
  using Base::lambda_;

 public:
  static constexpr const char* name = "symmetric_rigid_body";
  using typename Base::Algebra;
  using typename Base::Scalar;
  using typename Base::State;

  explicit SymmetricRigidBody(Vector<Scalar> lambda, Scalar epsilon = 1)
      : Base(std::move(lambda)), epsilon_(epsilon), G_(Base::zero()) {}

  Scalar epsilon() const { return epsilon_; }

  void generator(const State& x, Algebra& Omega) {
    const Eigen::Index N = lambda_.size();
    stoppable_product(x.topRows(N).transpose(), x.bottomRows(N), G_);
    inverse_inertia(lambda_, G_, epsilon_, Omega);
  }

 private:
  Scalar epsilon_;
  Algebra G_;
};

}  // namespace stiefel
