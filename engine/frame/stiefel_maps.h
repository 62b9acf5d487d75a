#pragma once

#include "engine/frame/ellipsoid.h"
#include "engine/frame/geodesics/isotropic_geodesic.h"
#include "engine/frame/rattle_stiefel.h"
#include "engine/frame/stiefel.h"
#include "engine/methods/exact.h"
#include "engine/methods/variational.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

// The maps of methods that are made for geodesics on V(n, N), and on the ellipsoid by velocity.

template <class Scalar>
auto map_of(Variational, const Stiefel<Scalar>& system, Scalar h, const MethodOptions& options) {
  return composed(
      [system](Scalar stage, Arithmetic arithmetic) {
        return RattleStiefel<Scalar>(system.lambda(), system.n(), stage, arithmetic);
      },
      h, options);
}
/// The energy oscillates.
template <class Scalar>
inline constexpr Declared declared<Variational, Stiefel<Scalar>> = {
    .conservation = [](std::string_view invariant) {
      return invariant == family::energy ? Conservation::bounded : Conservation::exact;
    }};

template <class Scalar>
auto map_of(Exact, const Stiefel<Scalar>& system, Scalar h, const MethodOptions&) {
  using Wide = Extended<Scalar>;
  return closed_form_map<Matrix<Scalar>>(
      [system](const Matrix<Scalar>& start) {
        return IsotropicGeodesic<Wide>(system.lambda().template cast<Wide>(),
                                       start.template cast<Wide>());
      },
      h);
}
template <class Scalar>
inline constexpr Declared declared<Exact, Stiefel<Scalar>> = {
    .where = "Lambda a multiple of the identity",
    .takes = IsotropicGeodesic<Extended<Scalar>>::has};

template <class Scalar>
auto map_of(Variational, const Ellipsoid<Scalar>& system, Scalar h, const MethodOptions& options) {
  return composed(
      [system](Scalar stage, Arithmetic arithmetic) {
        return RattleStiefel<Scalar>(system.lambda(), 1, stage, arithmetic, LowerBlock::Qdot);
      },
      h, options);
}
template <class Scalar>
inline constexpr Declared declared<Variational, Ellipsoid<Scalar>> = {
    .conservation = [](std::string_view invariant) {
      return invariant == family::orthogonality ? Conservation::exact : Conservation::bounded;
    }};

}  // namespace stiefel
