#pragma once

#include "engine/methods/concepts.h"
#include "engine/methods/method.h"

namespace stiefel {

/// The explicit midpoint rule on a Lie group, of order 2 (Munthe-Kaas 1998): with the generator
/// hξ(x) that moves a state x by the group's action,
///
///     x' = x·exp(hξ(x·exp(½hξ(x)))).
///
/// The state stays on its orbit of the group: Q stays orthogonal, and QMQᵀ and the eigenvalues of M
/// are kept, all to rounding.
struct LieMidpoint : LieMethod {
  static constexpr MethodTraits traits = {
      .name = "lie_midpoint",
      .summary = "explicit midpoint rule on the group",
      .source = "Munthe-Kaas 1998",
      .file = "tests/support/toys/lie_midpoint.h",
      .orders = {2},
      .default_order = 2,
      .reversible = false,
  };

  template <LieSystem S>
  class Map : public ExplicitMap<Map<S>, S> {
   public:
    using Point = typename S::State;
    Map(S system, typename S::Scalar h, const MethodOptions& options)
        : ExplicitMap<Map, S>(std::move(system), h, options),
          xi_(this->system_.zero()),
          theta_(xi_) {}

    void displacement(const Point& x, Point& dx) {
      this->system_.generator(x, xi_);
      theta_ = (this->h_ / 2) * xi_;
      this->system_.displacement(x, theta_, dx);
      dx += x;
      this->system_.generator(dx, xi_);
      theta_ = this->h_ * xi_;
      this->system_.displacement(x, theta_, dx);
    }

   private:
    typename S::Algebra xi_, theta_;
  };
};

}  // namespace stiefel
