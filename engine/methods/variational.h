#pragma once

#include "engine/maps/moser_veselov.h"
#include "engine/maps/rattle_stiefel.h"
#include "engine/methods/method.h"
#include "engine/systems/ellipsoid.h"
#include "engine/systems/rigid_body.h"
#include "engine/systems/stiefel.h"

namespace stiefel {

/// The variational integrator: for the rigid body it is the Moser–Veselov map, on V(n, N) RATTLE,
/// and at n = N these are one. `MapOf<S>::type<arithmetic>(system, h)` is the map of a system.
struct Variational {
  static constexpr MethodTraits traits = {
      .name = "variational",
      .summary = "discrete variational principle; at n = N the Moser-Veselov map",
      .source = "[RB] (4.5), Moser and Veselov 1991; Andersen 1983",
      .file = "engine/methods/variational.h",
      .orders = {2},
      .default_order = 2,
      .reversible = true,
  };
  static constexpr Kept kept(std::string_view) { return Kept::exact; }

  template <class S>
  struct MapOf;
  template <class Space>
  struct MapOf<RigidBody<Space>> {
    template <Arithmetic arithmetic>
    struct type : MoserVeselov<Space, arithmetic> {
      type(const RigidBody<Space>& body, typename Space::Scalar h)
          : MoserVeselov<Space, arithmetic>(body.lambda(), h) {}
    };
  };
  template <class Scalar>
  struct MapOf<Stiefel<Scalar>> {
    template <Arithmetic arithmetic>
    struct type : RattleStiefel<Scalar, arithmetic> {
      type(const Stiefel<Scalar>& system, Scalar h)
          : RattleStiefel<Scalar, arithmetic>(system.lambda(), system.n(), h) {}
    };
  };
  template <class Scalar>
  struct MapOf<Ellipsoid<Scalar>> {
    template <Arithmetic arithmetic>
    struct type : RattleStiefel<Scalar, arithmetic, Under::Qdot> {
      type(const Ellipsoid<Scalar>& system, Scalar h)
          : RattleStiefel<Scalar, arithmetic, Under::Qdot>(system.lambda(), 1, h) {}
    };
  };
  template <class S>
  static constexpr bool applies = requires {
    sizeof(MapOf<S>);
  };

  template <class S, Arithmetic arithmetic>
  class Map : public MapOf<S>::template type<arithmetic> {
   public:
    Map(const S& system, typename S::Scalar h, int)
        : MapOf<S>::template type<arithmetic>(system, h) {}
  };
};

}  // namespace stiefel
