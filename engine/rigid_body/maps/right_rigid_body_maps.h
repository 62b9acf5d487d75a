#pragma once

#include "engine/rigid_body/body/right_rigid_body.h"
#include "engine/rigid_body/maps/rigid_body_maps.h"
#include "engine/rigid_body/maps/turned_bodies.h"
#include "engine/rigid_body/symmetric/transposed.h"

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
