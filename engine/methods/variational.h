#pragma once

#include "engine/methods/composition.h"
#include "engine/methods/method.h"

namespace stiefel {

/// The variational integrator: the Moser–Veselov map for the rigid body, RATTLE on V(n, N); at n =
/// N the two are the same map. The orders 4, 6 and 8 are symmetric compositions of it.
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

  static constexpr Conservation conservation(const SystemTraits&, std::string_view) {
    return Conservation::exact;
  }
};

/// Returns the composition, of the order that `options` say, of the maps order_2(h, arithmetic).
template <class Order2, class Scalar>
auto composed(Order2 order_2, Scalar h, const MethodOptions& options) {
  const auto stage = [order_2, arithmetic = options.arithmetic](Scalar of_stage) {
    return order_2(of_stage, arithmetic);
  };
  return Composition<decltype(stage(h))>(stage, h, options.order);
}

}  // namespace stiefel
