#pragma once

#include "engine/maps/symmetric_moser_veselov.h"
#include "engine/maps/transposed.h"
#include "engine/methods/variational.h"
#include "engine/systems/right_rigid_body.h"
#include "engine/systems/right_symmetric_rigid_body.h"
#include "engine/systems/symmetric_rigid_body.h"

namespace stiefel {

// The variational integrator of the other forms of the rigid body. Symmetric: (SDRBn), which is the
// Moser–Veselov map under Ψ. Right-invariant: the transpose of the left-invariant map.

template <class Scalar>
struct Variational::MapOf<RightRigidBody<Scalar>> {
  template <Arithmetic arithmetic>
  using type = Transposed<MoserVeselov<SoN<Scalar>, arithmetic>, arithmetic>;
};
template <class Scalar>
struct Variational::MapOf<SymmetricRigidBody<Scalar>> {
  template <Arithmetic arithmetic>
  using type = SymmetricMoserVeselov<Scalar, arithmetic>;
};
template <class Scalar>
struct Variational::MapOf<RightSymmetricRigidBody<Scalar>> {
  template <Arithmetic arithmetic>
  using type = Transposed<SymmetricMoserVeselov<Scalar, arithmetic>, arithmetic>;
};

template <class Scalar, Arithmetic arithmetic>
class Variational::Map<SymmetricRigidBody<Scalar>, arithmetic>
    : public SymmetricMoserVeselov<Scalar, arithmetic> {
 public:
  Map(const SymmetricRigidBody<Scalar>& system, Scalar h, int)
      : SymmetricMoserVeselov<Scalar, arithmetic>(system.lambda(), h, system.epsilon()) {}
};
template <class Scalar, Arithmetic arithmetic>
class Variational::Map<RightSymmetricRigidBody<Scalar>, arithmetic>
    : public Transposed<SymmetricMoserVeselov<Scalar, arithmetic>, arithmetic> {
 public:
  Map(const RightSymmetricRigidBody<Scalar>& system, Scalar h, int)
      : Transposed<SymmetricMoserVeselov<Scalar, arithmetic>, arithmetic>(system.lambda(), h,
                                                                          system.epsilon()) {}
};

}  // namespace stiefel
