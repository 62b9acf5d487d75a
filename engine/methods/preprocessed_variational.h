#pragma once

#include "engine/rigid_body/moser_veselov/preprocessed_moser_veselov.h"
#include "engine/methods/support/method.h"
#include "engine/rigid_body/body/rigid_body.h"

namespace stiefel {

/// The variational integrator of the rigid body in three dimensions with the even orders 4 to 16,
/// each at the cost of order 2: the Moser–Veselov map with modified moments of inertia.
struct PreprocessedVariational {
  static constexpr MethodTraits traits = {
      .name = "preprocessed_variational",
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

  template <class S>
  static constexpr bool has_map_for = rigid_body_in_3d<S>;
  template <class>
  static constexpr Conservation conservation(std::string_view) {
    return Conservation::exact;
  }

  template <class S>
  requires rigid_body_in_3d<S>
  class Map : public PreprocessedMoserVeselov<typename S::Scalar, S::Space::has_frame> {
   public:
    using Moved = PreprocessedMoserVeselov<typename S::Scalar, S::Space::has_frame>;
    Map(const S& body, typename S::Scalar h, const MethodOptions& options)
        : Base(body.lambda(), h, options.order, options.arithmetic, body.has_frame()) {}

   private:
    using Base = PreprocessedMoserVeselov<typename S::Scalar, S::Space::has_frame>;
  };
};

}  // namespace stiefel
