#pragma once

#include "engine/methods/concepts.h"
#include "engine/methods/method.h"

namespace stiefel {

/// The Runge–Kutta–Munthe-Kaas method of order 4 with two commutators (Munthe-Kaas and Owren 1999).
/// With x(t) = x·exp(Θ(t)) and ẋ = x·ξ(x) acting from the right, Θ̇ = dexp⁻¹_{−Θ} ξ = ξ + ½[Θ, ξ] +
/// …, so both commutators have a plus sign:
///
///     k1 = hξ(x),                    k2 = hξ(x·exp(½k1)),
///     k3 = hξ(x·exp(½k2 + ⅛[k1, k2])),  k4 = hξ(x·exp(k3)),
///     x′ = x·exp((k1 + 2k2 + 2k3 + k4 + ½[k1, k4]) / 6).
///
/// The state stays on its orbit of the group: Q stays orthogonal, and QMQᵀ and the eigenvalues of M
/// are kept, all to rounding.
struct MuntheKaas4 : LieMethod {
  static constexpr MethodTraits traits = {
      .name = "munthe_kaas4",
      .summary = "Runge-Kutta-Munthe-Kaas on the group",
      .source = "Munthe-Kaas 1998; Munthe-Kaas and Owren 1999",
      .file = "engine/methods/munthe_kaas4.h",
      .orders = {4},
      .default_order = 4,
      .reversible = false,
      .momentum_alone = true,
  };

  template <LieSystem S>
  class Map : public ExplicitMap<Map<S>, S> {
   public:
    using Point = typename S::State;
    using Algebra = typename S::Algebra;
    Map(S system, typename S::Scalar h, const MethodOptions& options)
        : Base(std::move(system), h, options),
          k1_(system_.zero()),
          k2_(k1_),
          k3_(k1_),
          k4_(k1_),
          theta_(k1_),
          commutator_(k1_) {}

    void displacement(const Point& x, Point& dx) {
      stage(x, k1_);
      theta_ = k1_ / 2;
      stage_after(x, theta_, dx, k2_);
      system_.bracket(k1_, k2_, commutator_);
      theta_ = k2_ / 2 + commutator_ / 8;
      stage_after(x, theta_, dx, k3_);
      stage_after(x, k3_, dx, k4_);
      system_.bracket(k1_, k4_, commutator_);
      theta_ = (k1_ + 2 * k2_ + 2 * k3_ + k4_ + commutator_ / 2) / 6;
      system_.displacement(x, theta_, dx);
    }

   private:
    using Base = ExplicitMap<Map, S>;
    using Base::h_;
    using Base::system_;

    void stage(const Point& x, Algebra& k) {
      system_.generator(x, k);
      k *= h_;
    }
    /// Sets k = hξ(x·exp(Θ)).
    void stage_after(const Point& x, const Algebra& theta, Point& moved, Algebra& k) {
      system_.displacement(x, theta, moved);
      moved += x;
      stage(moved, k);
    }

    Algebra k1_, k2_, k3_, k4_, theta_, commutator_;
  };
};

}  // namespace stiefel
