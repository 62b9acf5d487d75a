#pragma once

#include "engine/linalg/matrix_equations/inertia_operator.h"
#include "engine/methods/support/moved_by.h"
#include "engine/numbers/stoppable_product.h"

namespace stiefel {

/// The symmetric representation of the rigid body, right-invariant: [RB] (RightSRBn), with the
/// scaling ε of Prop. 3.13,
///
///     Q̇_r = Ω_r Q_r,   Ṗ_r = Ω_r P_r,   Ω_r = J⁻¹(M_r),   M_r = (P_rQ_rᵀ − Q_rP_rᵀ)/ε.
///
/// Q_r = Qᵀ and P_r = Pᵀ for Q and P of the left-invariant form (Prop. 3.4). The motion keeps
/// Q_rᵀP_r, hence m_r = Q_rᵀM_rQ_r, and the energy. State: Q_r over P_r, 2N × N. SO(N) acts from
/// the left on both blocks.
template <class Scalar_>
class RightSymmetricRigidBody
    : public MovedBy<RightSymmetricRigidBody<Scalar_>, LeftMultiplication<Scalar_>> {
  using Base = MovedBy<RightSymmetricRigidBody, LeftMultiplication<Scalar_>>;
  using Base::lambda_;

 public:
  static constexpr const char* name = "right_symmetric_rigid_body";
  using typename Base::Algebra;
  using typename Base::Scalar;
  using typename Base::State;

  explicit RightSymmetricRigidBody(Vector<Scalar> lambda, Scalar epsilon = 1)
      : Base(std::move(lambda)), epsilon_(epsilon), G_(Base::zero()) {}

  Scalar epsilon() const { return epsilon_; }

  void generator(const State& x, Algebra& Omega) {
    const Eigen::Index N = lambda_.size();
    stoppable_product(x.bottomRows(N), x.topRows(N).transpose(), G_);
    inverse_inertia(lambda_, G_, epsilon_, Omega);
  }

 private:
  Scalar epsilon_;
  Algebra G_;
};

}  // namespace stiefel
