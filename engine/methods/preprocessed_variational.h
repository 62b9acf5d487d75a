#pragma once

#include "engine/methods/method.h"

namespace stiefel {

/// The variational integrator of the rigid body in three dimensions with the even orders 4 to 16,
/// each at the cost of order 2: the Moser–Veselov map with modified moments of inertia.
struct PreprocessedVariational {
  static constexpr MethodTraits traits = {
      .name = method_name::preprocessed,
      .summary = "Moser-Veselov map with modified moments of inertia, N = 3",
      .source = "Hairer and Vilmart 2006",
      .file = "engine/methods/preprocessed_variational.h",
      .orders = {4, 6, 8, 10, 12, 14, 16},
      .default_order = 4,
      .reversible = true,
      .iterates = true,
      .in_float = true,
      .packing = Packing::modified_inertia,
  };

  static constexpr Conservation conservation(const SystemTraits&, std::string_view) {
    return Conservation::exact;
  }
};

}  // namespace stiefel
