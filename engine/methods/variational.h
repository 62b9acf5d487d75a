#pragma once

#include "engine/maps/moser_veselov.h"
#include "engine/methods/composition.h"
#include "engine/methods/method.h"
#include "engine/systems/rigid_body.h"

namespace stiefel {

/// The variational integrator: for the rigid body (n = N) it is the Moser–Veselov map; symmetric
/// compositions of it for the orders 4, 6 and 8.
struct Variational {
  static constexpr MethodTraits traits = {
      .name = "variational",
      .summary = "discrete variational principle; at n = N the Moser-Veselov map",
      .source = "[RB] (4.5), Moser and Veselov 1991; Suzuki 1990, Kahan and Li 1997",
      .file = "engine/methods/variational.h",
      .orders = {2, 4, 6, 8},
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
  class Map : public Composition<typename MapOf<S>::template type<arithmetic>> {
   public:
    using Scalar = typename S::Scalar;
    Map(const S& system, Scalar h, int order) : Composed(stage_of(system), h, order) {}

   private:
    using Base = typename MapOf<S>::template type<arithmetic>;
    using Composed = Composition<Base>;

    static typename Composed::Make stage_of(const S& system) {
      return [lambda = system.lambda()](Scalar h) { return Base(lambda, h); };
    }
  };
};

}  // namespace stiefel
