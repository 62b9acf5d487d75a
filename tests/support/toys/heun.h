#pragma once

#include "engine/methods/concepts.h"
#include "engine/methods/method.h"

namespace stiefel {

/// Heun's method of order 2 (Heun 1900): x' = x + h/2 (X(x) + X(x + hX(x))).
struct Heun {
  static constexpr MethodTraits traits = {
      .name = "heun",
      .summary = "explicit trapezoidal rule",
      .source = "Heun 1900",
      .file = "tests/support/toys/heun.h",
      .orders = {2},
      .default_order = 2,
      .reversible = false,
  };
  static constexpr bool applies_to(const SystemTraits&) { return true; }
  static constexpr Conservation conservation(const SystemTraits&, std::string_view) {
    return Conservation::drifts;
  }

  template <System S>
  class Map : public ExplicitMap<Map<S>, S> {
   public:
    using Point = typename S::State;
    Map(S system, typename S::Scalar h, const MethodOptions& options)
        : ExplicitMap<Map, S>(std::move(system), h, options) {}

    void displacement(const Point& x, Point& dx) {
      if (k1_.size() != x.size()) k1_ = k2_ = stage_ = x;
      this->system_.field(x, k1_);
      stage_ = x + this->h_ * k1_;
      this->system_.field(stage_, k2_);
      dx = (this->h_ / 2) * (k1_ + k2_);
    }

   private:
    Point k1_, k2_, stage_;
  };
};

}  // namespace stiefel
