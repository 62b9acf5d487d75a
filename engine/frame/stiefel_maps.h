#pragma once

#include "engine/frame/geodesics/isotropic_geodesic.h"
#include "engine/frame/rattle_stiefel.h"
#include "engine/frame/stiefel.h"
#include "engine/methods/exact.h"
#include "engine/methods/variational.h"
#include "engine/motion/tangent_map.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

// The maps of methods that are made for geodesics on V(n, N).

template <class Scalar>
auto map_of(Variational, const Stiefel<Scalar>& system, Scalar h, const MethodOptions& options) {
  return composed(
      [system](Scalar stage, Arithmetic arithmetic) {
        return RattleStiefel<Scalar>(system.lambda(), system.n(), stage, arithmetic);
      },
      h, options);
}
/// The energy oscillates, and so do the other integrals of a point.
template <class Scalar>
inline constexpr Declared declared<Variational, Stiefel<Scalar>> = {
    .conservation = [](std::string_view invariant) {
      const bool oscillates = invariant == family::energy || invariant == family::joachimsthal ||
                              invariant == family::lax;
      return oscillates ? Conservation::bounded : Conservation::exact;
    }};

/// Returns the tangent of the variational step on V(n, N), of any order.
std::unique_ptr<TangentMap> rattle_tangent(const Scene& scene, const TangentParameters& at);

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

}  // namespace stiefel
