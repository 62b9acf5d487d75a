#pragma once

#include "engine/frame/ellipsoid.h"
#include "engine/frame/geodesics/isotropic_geodesic.h"
#include "engine/frame/rattle_stiefel.h"
#include "engine/frame/stiefel.h"
#include "engine/methods/exact.h"
#include "engine/methods/variational.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

// The maps of methods that are made for geodesics on V(n, N).

template <class Scalar>
struct Variational::MapOf<Stiefel<Scalar>> {
  static constexpr bool keeps(std::string_view invariant) { return invariant != family::energy; }
  static RattleStiefel<Scalar> make(const Stiefel<Scalar>& system, Scalar h,
                                    Arithmetic arithmetic) {
    return {system.lambda(), system.n(), h, arithmetic};
  }
};

template <class Scalar>
struct Exact::MotionOf<Stiefel<Scalar>> {
  using Wide = Extended<Scalar>;
  static constexpr std::string_view where = "Lambda a multiple of the identity";
  static bool takes(const Eigen::VectorXd& lambda) { return IsotropicGeodesic<Wide>::has(lambda); }
  static IsotropicGeodesic<Wide> make(const Stiefel<Scalar>& system, const Matrix<Scalar>& start) {
    return {system.lambda().template cast<Wide>(), start.template cast<Wide>()};
  }
};

template <class Scalar>
struct SpecialMethods<Stiefel<Scalar>> {
  using type = TypeList<Variational, Exact>;
};

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
