#pragma once

#include "engine/methods/special/rigid_body.h"
#include "engine/methods/special/turned_bodies.h"
#include "engine/methods/support/transposed.h"
#include "engine/systems/right_rigid_body.h"

namespace stiefel {

// Maps made for the right-invariant rigid body: the transposes of the left-invariant maps.

template <class Scalar>
struct Variational::MapOf<RightRigidBody<Scalar>> {
  static constexpr bool keeps(std::string_view) { return true; }
  static Transposed<MoserVeselov<SoN<Scalar>>> make(const RightRigidBody<Scalar>& body, Scalar h,
                                                    Arithmetic arithmetic) {
    return {MoserVeselov<SoN<Scalar>>(body.lambda(), h, arithmetic), arithmetic};
  }
};

template <class Scalar>
struct Gauss4::InQAndP<RightRigidBody<Scalar>> {
  using Symmetric = SymmetricRigidBody<Scalar>;
  using Map = Transposed<typename InQAndP<RigidBody<SoN<Scalar>>>::Map>;
  static Map make(const RightRigidBody<Scalar>& body, Scalar h, Arithmetic arithmetic) {
    return {typename InQAndP<RigidBody<SoN<Scalar>>>::Map(body.lambda(), h, arithmetic),
            arithmetic};
  }
};

template <class Scalar>
struct SpecialMethods<RightRigidBody<Scalar>> {
  using type = TypeList<Variational, Gauss4, Exact>;
};

}  // namespace stiefel
