#pragma once

#include "engine/maps/moser_veselov.h"
#include "engine/maps/rattle_stiefel.h"
#include "engine/maps/symmetric_moser_veselov.h"
#include "engine/methods/support/composition.h"
#include "engine/methods/support/method.h"
#include "engine/methods/support/transposed.h"
#include "engine/systems/ellipsoid.h"
#include "engine/systems/right_rigid_body.h"
#include "engine/systems/right_symmetric_rigid_body.h"
#include "engine/systems/rigid_body.h"
#include "engine/systems/stiefel.h"
#include "engine/systems/symmetric_rigid_body.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

/// The variational integrator: the Moser–Veselov map for the rigid body, RATTLE on V(n, N); at n =
/// N the two are the same map. The orders 4, 6 and 8 are symmetric compositions of it.
/// `MapOf<S>::make<arithmetic>(system, h)` returns the map of order 2.
struct Variational {
  static constexpr MethodTraits traits = {
      .name = "variational",
      .summary = "discrete variational principle; at n = N the Moser-Veselov map",
      .source = "[RB] (4.5), Moser and Veselov 1991; Andersen 1983; Suzuki 1990, Kahan and Li 1997",
      .file = "engine/methods/variational.h",
      .orders = {2, 4, 6, 8},
      .default_order = 2,
      .reversible = true,
      .in_float = true,
      .in_so4 = true,
      .packing = Packing::stages,
  };

  template <class S>
  struct MapOf;
  template <class S>
  static constexpr bool applies = requires(std::string_view v) {
    MapOf<S>::keeps(v);
  };
  /// The discrete rigid body keeps every integral; on V(n, N) the energy oscillates.
  template <class S>
  static constexpr Conservation conservation(std::string_view invariant) {
    return MapOf<S>::keeps(invariant) ? Conservation::exact : Conservation::bounded;
  }

  template <class S, Arithmetic arithmetic>
  using MapOfOrder2 =
      decltype(MapOf<S>::template make<arithmetic>(std::declval<const S&>(), typename S::Scalar()));
  template <class S, Arithmetic arithmetic>
  class Map : public Composition<MapOfOrder2<S, arithmetic>> {
   public:
    using Scalar = typename S::Scalar;
    Map(const S& system, Scalar h, int order)
        : Composition<MapOfOrder2<S, arithmetic>>(
              [system](Scalar stage) { return MapOf<S>::template make<arithmetic>(system, stage); },
              h, order) {}
  };
};

template <class Space>
struct Variational::MapOf<RigidBody<Space>> {
  static constexpr bool keeps(std::string_view) { return true; }
  template <Arithmetic arithmetic>
  static MoserVeselov<Space, arithmetic> make(const RigidBody<Space>& body,
                                              typename Space::Scalar h) {
    return {body.lambda(), h};
  }
};

/// Right-invariant systems use the transpose of the left-invariant map.
template <class Scalar>
struct Variational::MapOf<RightRigidBody<Scalar>> {
  static constexpr bool keeps(std::string_view) { return true; }
  template <Arithmetic arithmetic>
  static Transposed<MoserVeselov<SoN<Scalar>, arithmetic>, arithmetic> make(
      const RightRigidBody<Scalar>& body, Scalar h) {
    return Transposed<MoserVeselov<SoN<Scalar>, arithmetic>, arithmetic>(body.lambda(), h);
  }
};

/// The symmetric representation uses (SDRBn), which is the Moser–Veselov map under Ψ.
template <class Scalar>
struct Variational::MapOf<SymmetricRigidBody<Scalar>> {
  static constexpr bool keeps(std::string_view) { return true; }
  template <Arithmetic arithmetic>
  static SymmetricMoserVeselov<Scalar, arithmetic> make(const SymmetricRigidBody<Scalar>& body,
                                                        Scalar h) {
    return {body.lambda(), h, body.epsilon()};
  }
};
template <class Scalar>
struct Variational::MapOf<RightSymmetricRigidBody<Scalar>> {
  static constexpr bool keeps(std::string_view) { return true; }
  template <Arithmetic arithmetic>
  static Transposed<SymmetricMoserVeselov<Scalar, arithmetic>, arithmetic> make(
      const RightSymmetricRigidBody<Scalar>& body, Scalar h) {
    return Transposed<SymmetricMoserVeselov<Scalar, arithmetic>, arithmetic>(body.lambda(), h,
                                                                             body.epsilon());
  }
};

template <class Scalar>
struct Variational::MapOf<Stiefel<Scalar>> {
  static constexpr bool keeps(std::string_view invariant) { return invariant != family::energy; }
  template <Arithmetic arithmetic>
  static RattleStiefel<Scalar, arithmetic> make(const Stiefel<Scalar>& system, Scalar h) {
    return {system.lambda(), system.n(), h};
  }
};
template <class Scalar>
struct Variational::MapOf<Ellipsoid<Scalar>> {
  static constexpr bool keeps(std::string_view invariant) {
    return invariant == family::orthogonality;
  }
  template <Arithmetic arithmetic>
  static RattleStiefel<Scalar, arithmetic, LowerBlock::Qdot> make(const Ellipsoid<Scalar>& system,
                                                                  Scalar h) {
    return {system.lambda(), 1, h};
  }
};

}  // namespace stiefel
