#pragma once

#include "engine/methods/variational.h"
#include "engine/rigid_body/maps/turned_bodies.h"
#include "engine/rigid_body/moser_veselov/symmetric_moser_veselov.h"
#include "engine/rigid_body/symmetric/symmetric_rigid_body.h"

namespace stiefel {

// The map of a method that is made for the symmetric representation: (SDRBn), which is the
// Moser–Veselov map under Ψ.

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

}  // namespace stiefel
