#pragma once

#include "engine/methods/concepts.h"
#include "engine/methods/method.h"

namespace stiefel {

/// The classical Runge–Kutta method of order 4 (Kutta 1901). Every invariant drifts.
///
///     k1 = X(x), k2 = X(x + h/2 k1), k3 = X(x + h/2 k2), k4 = X(x + h k3),
///     x′ = x + h/6 (k1 + 2(k2 + k3) + k4).
struct Rk4 {
  static constexpr MethodTraits traits = {
      .name = method_name::rk4,
      .summary = "classical Runge-Kutta",
      .source = "Kutta 1901",
      .file = "engine/methods/rk4.h",
      .orders = {4},
      .default_order = 4,
      .reversible = false,
      .in_float = true,
      .momentum_alone = true,
      .in_so4 = true,
      .packing = Packing::vector_field,
  };
  static constexpr bool applies_to(const SystemTraits&) { return true; }
  static constexpr Conservation conservation(const SystemTraits& system,
                                             std::string_view invariant) {
    return system.without_trend && system.without_trend(invariant) ? Conservation::bounded
                                                                   : Conservation::drifts;
  }

  template <System S>
  class Map : public ExplicitMap<Map<S>, S> {
   public:
    using Point = typename S::State;
    Map(S system, typename S::Scalar h, const MethodOptions& options)
        : Base(std::move(system), h, options) {}

    void displacement(const Point& x, Point& dx) { inlined_displacement(x, dx); }
    /// Computes the displacement, inlined: packs keep the stages in registers from step to step.
    [[gnu::always_inline]] void inlined_displacement(const Point& x, Point& dx) {
      if (k1_.size() != x.size()) k1_ = k2_ = k3_ = k4_ = stage_ = x;
      system_.field(x, k1_);
      stage_ = x + (h_ / 2) * k1_;
      system_.field(stage_, k2_);
      stage_ = x + (h_ / 2) * k2_;
      system_.field(stage_, k3_);
      stage_ = x + h_ * k3_;
      system_.field(stage_, k4_);
      dx = (h_ / 6) * (k1_ + 2 * (k2_ + k3_) + k4_);
    }

   private:
    using Base = ExplicitMap<Map, S>;
    using Base::h_;
    using Base::system_;
    Point k1_, k2_, k3_, k4_, stage_;
  };
};

}  // namespace stiefel
