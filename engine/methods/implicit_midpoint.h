#pragma once

#include "engine/methods/implicit_map.h"

namespace stiefel {

/// The isospectral midpoint rule on (Q, M) (Modin and Viviani 2020):
///
///     M = (I + a)M̃(I − a),   a = (h/2)J⁻¹(M̃),
///     M′ = (I − a)M̃(I + a),   Q′ = Q(I + a)(I − a)⁻¹,
///
/// which is the midpoint rule on (Q, P), expressed in (Q, M). Order 2, time-symmetric, Poisson:
/// keeps QMQᵀ, the eigenvalues of M and the orthogonality of Q to rounding; the energy error stays
/// bounded. (The midpoint rule applied to (Q, M) keeps the energy and loses QMQᵀ.)
struct ImplicitMidpoint {
  static constexpr MethodTraits traits = {
      .name = "implicit_midpoint",
      .summary = "isospectral midpoint rule",
      .source = "Modin and Viviani 2020",
      .file = "engine/methods/implicit_midpoint.h",
      .orders = {2},
      .default_order = 2,
      .reversible = true,
      .iterates = true,
  };
  static constexpr Conservation conservation(const SystemTraits& system,
                                             std::string_view invariant) {
    return system.conserved_on_orbits(invariant) ? Conservation::exact : Conservation::bounded;
  }

  /// `Cayley` computes the products with I + a and (I − a)⁻¹ for the states of S.
  template <LieSystem S, class Cayley>
  class Map : public ImplicitMap<Map<S, Cayley>, S> {
   public:
    using Point = typename S::State;
    using Scalar = typename S::Scalar;
    Map(S system, Scalar h, const MethodOptions& options)
        : Base(std::move(system), h, options.arithmetic),
          cayley_(system_.lambda().size()),
          a_(system_.zero()),
          Omega_(a_) {}

    void begin(const Point& x, Matrix<Scalar>& a) {
      middle_ = x;
      a.setZero(a_.rows(), a_.cols());
    }

    void sweep(const Point& x, const Matrix<Scalar>& a, Scalar h, Matrix<Scalar>& g) {
      cayley_.midpoint(x, element(a), middle_);
      system_.generator(middle_, Omega_);
      g = (h / 2) * Omega_;
    }

    void displacement(const Point& x, const Matrix<Scalar>& a, Point& dx) {
      cayley_.displacement(x, element(a), dx);
    }

   private:
    using Base = ImplicitMap<Map, S>;
    using Base::system_;

    const typename S::Algebra& element(const Matrix<Scalar>& a) {
      if constexpr (std::is_same_v<typename S::Algebra, Matrix<Scalar>>) return a;
      a_ = a;
      return a_;
    }

    Cayley cayley_;
    typename S::Algebra a_, Omega_;
    Point middle_;
  };
};

}  // namespace stiefel
