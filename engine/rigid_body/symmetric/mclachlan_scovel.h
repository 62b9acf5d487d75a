#pragma once

#include "engine/linalg/matrix_equations/inertia_operator.h"
#include "engine/methods/support/moved_by.h"
#include "engine/numbers/stoppable_product.h"

namespace stiefel {

/// The McLachlan–Scovel equations [RB] (5.5),
///
///     Q̇ = QΩ,   Ḃ = BΩ,   Ω = J⁻¹(QᵀB),
///
/// on the invariant manifold where QᵀB is skew; there QᵀB = M and B = QM = P − QPᵀQ. Off the
/// manifold M is the skew part of QᵀB. The motion keeps BQᵀ = m, the energy and all other
/// invariants of the rigid body. State: Q over B, 2N × N. SO(N) acts from the right on both blocks.
template <class Scalar_>
class McLachlanScovel : public MovedBy<McLachlanScovel<Scalar_>, RightMultiplication<Scalar_>> {
  using Base = MovedBy<McLachlanScovel, RightMultiplication<Scalar_>>;
  using Base::lambda_;

 public:
  static constexpr const char* name = "mclachlan_scovel";
  using typename Base::Algebra;
  using typename Base::Scalar;
  using typename Base::State;

  explicit McLachlanScovel(Vector<Scalar> lambda) : Base(std::move(lambda)), G_(Base::zero()) {}

  void generator(const State& x, Algebra& Omega) {
    const Eigen::Index N = lambda_.size();
    stoppable_product(x.topRows(N).transpose(), x.bottomRows(N), G_);
    inverse_inertia(lambda_, G_, Scalar(2), Omega);
  }

 private:
  Algebra G_;
};

}  // namespace stiefel
