#pragma once

#include "engine/methods/variational.h"
#include "engine/rigid_body/maps/turned_bodies.h"
#include "engine/rigid_body/moser_veselov/symmetric_moser_veselov.h"
#include "engine/rigid_body/symmetric/right_symmetric_rigid_body.h"
#include "engine/rigid_body/symmetric/symmetric_rigid_body.h"
#include "engine/rigid_body/symmetric/transposed.h"

namespace stiefel {

// The maps of a method that is made for the symmetric representations: (SDRBn), which is the
// Moser–Veselov map under Ψ, and its transpose for the right-invariant one.

template <class Scalar>
struct Variational::MapOf<SymmetricRigidBody<Scalar>> {
  static constexpr bool keeps(std::string_view) { return true; }
  static SymmetricMoserVeselov<Scalar> make(const SymmetricRigidBody<Scalar>& body, Scalar h,
                                            Arithmetic arithmetic) {
    return {body.lambda(), h, body.epsilon(), arithmetic};
  }
};

template <class Scalar>
struct SpecialMethods<SymmetricRigidBody<Scalar>> {
  using type = TypeList<Variational, Exact>;
};

template <class Scalar>
struct Variational::MapOf<RightSymmetricRigidBody<Scalar>> {
  static constexpr bool keeps(std::string_view) { return true; }
  static Transposed<SymmetricMoserVeselov<Scalar>> make(const RightSymmetricRigidBody<Scalar>& body,
                                                        Scalar h, Arithmetic arithmetic) {
    return {SymmetricMoserVeselov<Scalar>(body.lambda(), h, body.epsilon(), arithmetic),
            arithmetic};
  }
};

template <class Scalar>
struct SpecialMethods<RightSymmetricRigidBody<Scalar>> {
  using type = TypeList<Variational, Exact>;
};

}  // namespace stiefel
