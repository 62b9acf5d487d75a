#pragma once

#include "engine/frames/body/ellipsoid.h"
#include "engine/frames/passes/rattle_stiefel.h"
#include "engine/methods/variational.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

// The map of a method that is made for geodesics on the ellipsoid, by velocity.

template <class Scalar>
struct Variational::MapOf<Ellipsoid<Scalar>> {
  static constexpr bool keeps(std::string_view invariant) {
    return invariant == family::orthogonality;
  }
  static RattleStiefel<Scalar> make(const Ellipsoid<Scalar>& system, Scalar h,
                                    Arithmetic arithmetic) {
    return {system.lambda(), 1, h, arithmetic, LowerBlock::Qdot};
  }
};

template <class Scalar>
struct SpecialMethods<Ellipsoid<Scalar>> {
  using type = TypeList<Variational>;
};

}  // namespace stiefel
