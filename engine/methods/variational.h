#pragma once

#include "engine/maps/moser_veselov.h"
#include "engine/methods/method.h"
#include "engine/systems/rigid_body.h"

namespace stiefel {

/// The variational integrator: for the rigid body (n = N) it is the Moser–Veselov map.
struct Variational {
  static constexpr MethodTraits traits = {
      .name = "variational",
      .summary = "discrete variational principle; at n = N the Moser-Veselov map",
      .source = "[RB] (4.5), Moser and Veselov 1991",
      .file = "engine/methods/variational.h",
      .orders = {2},
      .default_order = 2,
      .reversible = true,
  };
  template <class>
  static constexpr Kept kept(std::string_view) {
    return Kept::exact;
  }

  template <class S>
  struct MapOf;
  template <class Space>
  struct MapOf<RigidBody<Space>> {
    template <Arithmetic arithmetic>
    using type = MoserVeselov<Space, arithmetic>;
  };
  template <class S>
  static constexpr bool applies = requires {
    typename MapOf<S>::template type<Arithmetic::plain>;
  };

  template <class S, Arithmetic arithmetic>
  class Map : public MapOf<S>::template type<arithmetic> {
   public:
    Map(const S& system, typename S::Scalar h, int)
        : MapOf<S>::template type<arithmetic>(system.lambda(), h) {}
  };
};

}  // namespace stiefel
