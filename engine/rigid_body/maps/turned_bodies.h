#pragma once

#include "engine/methods/exact.h"
#include "engine/rigid_body/body/right_rigid_body.h"
#include "engine/rigid_body/exact/turned_body.h"
#include "engine/rigid_body/symmetric/left_right.h"
#include "engine/rigid_body/symmetric/mclachlan_scovel.h"
#include "engine/rigid_body/symmetric/mclachlan_scovel_blocks.h"
#include "engine/rigid_body/symmetric/psi.h"
#include "engine/rigid_body/symmetric/reduced_rigid_body.h"
#include "engine/rigid_body/symmetric/right_symmetric_rigid_body.h"
#include "engine/rigid_body/symmetric/symmetric_rigid_body.h"

namespace stiefel {

// The closed form in those forms of the rigid body that its rotation multiplies. Each is known by
// the momentum M of the left-invariant body in its variables.

/// Base class of the closed form of S; `Derived` offers M(system, x) and `by`.
template <class Derived, class S>
struct TurnedBodyOf {
  using Scalar = typename S::Scalar;
  using Wide = Extended<Scalar>;
  using Turned = TurnedBody<Wide>;
  static constexpr std::string_view where = "N = 3, or Lambda of at most two values";
  static bool takes(const Eigen::VectorXd& lambda) { return BodyRotation<Wide>::has(lambda); }

  static Turned make(const S& system, const Matrix<Scalar>& start) {
    const Matrix<Wide> x = start.template cast<Wide>();
    return {BodyRotation<Wide>(system.lambda().template cast<Wide>(), Derived::M(system, x)), x,
            Derived::by};
  }

 protected:
  static Matrix<Wide> top(const Matrix<Wide>& x) { return x.topRows(x.cols()); }
  static Matrix<Wide> bottom(const Matrix<Wide>& x) { return x.bottomRows(x.cols()); }
};

template <class Scalar>
struct Exact::MotionOf<RightRigidBody<Scalar>>
    : TurnedBodyOf<Exact::MotionOf<RightRigidBody<Scalar>>, RightRigidBody<Scalar>> {
  using Wide = Extended<Scalar>;
  static constexpr auto by = TurnedBody<Wide>::By::left_factor_and_M;
  static Matrix<Wide> M(const RightRigidBody<Scalar>&, const Matrix<Wide>& x) {
    return -x.bottomRows(x.cols());
  }
};

template <class Scalar>
struct Exact::MotionOf<SymmetricRigidBody<Scalar>>
    : TurnedBodyOf<Exact::MotionOf<SymmetricRigidBody<Scalar>>, SymmetricRigidBody<Scalar>> {
  using Wide = Extended<Scalar>;
  static constexpr auto by = TurnedBody<Wide>::By::right_factor;
  static Matrix<Wide> M(const SymmetricRigidBody<Scalar>& body, const Matrix<Wide>& x) {
    return Psi<Wide>(MotionOf::top(x), MotionOf::bottom(x), body.epsilon());
  }
};

template <class Scalar>
struct Exact::MotionOf<RightSymmetricRigidBody<Scalar>>
    : TurnedBodyOf<Exact::MotionOf<RightSymmetricRigidBody<Scalar>>,
                   RightSymmetricRigidBody<Scalar>> {
  using Wide = Extended<Scalar>;
  static constexpr auto by = TurnedBody<Wide>::By::left_factor;
  static Matrix<Wide> M(const RightSymmetricRigidBody<Scalar>& body, const Matrix<Wide>& x) {
    return -Psi_right<Wide>(MotionOf::top(x), MotionOf::bottom(x), body.epsilon());
  }
};

template <class Scalar>
struct Exact::MotionOf<ReducedRigidBody<Scalar>>
    : TurnedBodyOf<Exact::MotionOf<ReducedRigidBody<Scalar>>, ReducedRigidBody<Scalar>> {
  using Wide = Extended<Scalar>;
  static constexpr auto by = TurnedBody<Wide>::By::right_factor;
  static Matrix<Wide> M(const ReducedRigidBody<Scalar>& body, const Matrix<Wide>& Q) {
    return Psi<Wide>(Q, body.A().template cast<Wide>() * Q, body.epsilon());
  }
};

template <class Scalar>
struct Exact::MotionOf<McLachlanScovel<Scalar>>
    : TurnedBodyOf<Exact::MotionOf<McLachlanScovel<Scalar>>, McLachlanScovel<Scalar>> {
  using Wide = Extended<Scalar>;
  static constexpr auto by = TurnedBody<Wide>::By::right_factor;
  static Matrix<Wide> M(const McLachlanScovel<Scalar>&, const Matrix<Wide>& x) {
    return M_of_B<Wide>(MotionOf::top(x), MotionOf::bottom(x));
  }
};

template <class Scalar>
struct SpecialMethods<ReducedRigidBody<Scalar>> {
  using type = TypeList<Exact>;
};
template <class Scalar>
struct SpecialMethods<McLachlanScovel<Scalar>> {
  using type = TypeList<Exact>;
};

}  // namespace stiefel
