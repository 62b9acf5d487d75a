#pragma once

#include "engine/methods/support/concepts.h"
#include "engine/methods/support/method.h"

namespace stiefel {

/// The Crouch–Grossman method of order 3 with three stages (Crouch and Grossman 1993; Owren and
/// Marthinsen 1999), which uses products of exponentials and no commutator,
///
///     k1 = hξ(x),   k2 = hξ(x·exp(¾k1)),   k3 = hξ(x·exp(119/216 k1)·exp(17/108 k2)),
///     x′ = x·exp(13/51 k1)·exp(−⅔k2)·exp(24/17 k3).
///
/// The state stays on its orbit of the group: Q stays orthogonal, and QMQᵀ and the eigenvalues of M
/// are kept, all to rounding.
struct CrouchGrossman3 {
  static constexpr MethodTraits traits = {
      .name = "crouch_grossman3",
      .summary = "products of exponentials on the group",
      .source = "Crouch and Grossman 1993; Owren and Marthinsen 1999",
      .file = "engine/methods/crouch_grossman3.h",
      .orders = {3},
      .default_order = 3,
      .reversible = false,
      .momentum_alone = true,
  };
  static constexpr bool applies_to(const SystemTraits& system) { return system.lie_group; }
  static constexpr Conservation conservation(const SystemTraits& system,
                                             std::string_view invariant) {
    return system.conserved_on_orbits(invariant) ? Conservation::exact : Conservation::drifts;
  }

  template <LieSystem S>
  class Map : public ExplicitMap<Map<S>, S> {
   public:
    using Point = typename S::State;
    using Scalar = typename S::Scalar;
    using Algebra = typename S::Algebra;
    Map(S system, Scalar h, const MethodOptions& options)
        : Base(std::move(system), h, options),
          k1_(system_.zero()),
          k2_(k1_),
          k3_(k1_),
          theta_(k1_) {}

    void displacement(const Point& x, Point& dx) {
      const auto fraction = [](int p, int q) { return Scalar(p) / Scalar(q); };
      system_.generator(x, k1_);
      begin(x, dx);
      turn(x, fraction(3, 4), k1_, dx);
      system_.generator(moved_, k2_);
      begin(x, dx);
      turn(x, fraction(119, 216), k1_, dx);
      turn(x, fraction(17, 108), k2_, dx);
      system_.generator(moved_, k3_);
      begin(x, dx);
      turn(x, fraction(13, 51), k1_, dx);
      turn(x, fraction(-2, 3), k2_, dx);
      turn(x, fraction(24, 17), k3_, dx);
    }

   private:
    using Base = ExplicitMap<Map, S>;
    using Base::h_;
    using Base::system_;

    void begin(const Point& x, Point& dx) {
      moved_ = x;
      dx.setZero();
    }
    /// Sets x + dx ← (x + dx)·exp(weight·h·k).
    void turn(const Point& x, Scalar weight, const Algebra& k, Point& dx) {
      theta_ = (weight * h_) * k;
      if (turned_.size() != x.size()) turned_ = x;
      system_.displacement(moved_, theta_, turned_);
      dx += turned_;
      moved_ = x + dx;
    }

    Algebra k1_, k2_, k3_, theta_;
    Point moved_, turned_;
  };
};

}  // namespace stiefel
