#pragma once

#include "engine/methods/composition.h"
#include "engine/methods/method.h"

namespace stiefel {

/// The variational integrator: the Moser–Veselov map for the rigid body, RATTLE on V(n, N); at n =
/// N the two are the same map. The orders 4, 6 and 8 are symmetric compositions of it.
/// `MapOf<S>::make(system, h, arithmetic)` returns the map of order 2.
struct Variational {
  static constexpr MethodTraits traits = {
      .name = "variational",
      .summary = "discrete variational principle; at n = N the Moser-Veselov map",
      .source = "[RB] (4.5), Moser and Veselov 1991; Andersen 1983; Suzuki 1990, Kahan and Li 1997",
      .file = "engine/methods/variational.h",
      .orders = {2, 4, 6, 8},
      .default_order = 2,
      .reversible = true,
      .iterates = true,
      .in_float = true,
      .in_so4 = true,
      .packing = Packing::stages,
  };

  template <class S>
  struct MapOf;
  template <class S>
  static constexpr bool has_map_for = requires(std::string_view v) {
    MapOf<S>::keeps(v);
  };
  /// The discrete rigid body keeps every integral; on V(n, N) the energy oscillates.
  template <class S>
  static constexpr Conservation conservation(std::string_view invariant) {
    return MapOf<S>::keeps(invariant) ? Conservation::exact : Conservation::bounded;
  }

  template <class S>
  using MapOfOrder2 =
      decltype(MapOf<S>::make(std::declval<const S&>(), typename S::Scalar(), Arithmetic()));
  template <class S>
  class Map : public Composition<MapOfOrder2<S>> {
   public:
    using Moved = Composition<MapOfOrder2<S>>;
    using Scalar = typename S::Scalar;
    Map(const S& system, Scalar h, const MethodOptions& options)
        : Composition<MapOfOrder2<S>>(
              [system, arithmetic = options.arithmetic](Scalar stage) {
                return MapOf<S>::make(system, stage, arithmetic);
              },
              h, options.order) {}
  };
};

}  // namespace stiefel
