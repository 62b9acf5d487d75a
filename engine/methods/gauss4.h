#pragma once

#include "engine/methods/implicit_map.h"
#include "engine/systems/concepts.h"

namespace stiefel {

/// The Gauss method of two stages (Kuntzmann 1961, Butcher 1964), on the state as it stands:
///
///     K_1 = X(x + h(¼K_1 + (¼ − √3/6)K_2)),   K_2 = X(x + h((¼ + √3/6)K_1 + ¼K_2)),
///     x′ = x + (h/2)(K_1 + K_2).
///
/// Order 4, time-symmetric, symplectic; it keeps every quadratic invariant (Cooper 1987): QQᵀ and
/// PQᵀ in the variables (Q, P). It applies to systems that name their quadratic invariants, and the
/// functions of those, by `quadratic(invariant)`: the forms of the rigid body in (Q, P) or (Q, B).
/// In (Q, M) it would lose QMQᵀ.
struct Gauss4 {
  static constexpr MethodTraits traits = {
      .name = "gauss4",
      .summary = "Gauss collocation with two stages",
      .source = "Kuntzmann 1961, Butcher 1964; Cooper 1987",
      .file = "engine/methods/gauss4.h",
      .orders = {4},
      .default_order = 4,
      .reversible = true,
  };
  template <class S>
  static constexpr bool applies = System<S>&& requires(std::string_view v) {
    S::quadratic(v);
  };
  template <class S>
  static constexpr Kept kept(std::string_view invariant) {
    return S::quadratic(invariant) ? Kept::exact : Kept::bounded;
  }

  template <System S, Arithmetic arithmetic>
  class Map : public ImplicitMap<Map<S, arithmetic>, S, arithmetic> {
   public:
    using Point = typename S::State;
    using Scalar = typename S::Scalar;
    Map(S system, Scalar h, int) : Base(std::move(system), h) {}

    void begin(const Point& x, Matrix<Scalar>& K) {
      point_ = slope_ = x;
      system_.field(point_, slope_);
      K.resize(x.rows(), 2 * x.cols());
      K << slope_, slope_;
    }

    /// One rounded √3/6 for both stages: with two, the quadratic invariants drift.
    void sweep(const Point& x, const Matrix<Scalar>& K, Scalar h, Matrix<Scalar>& g) {
      using std::sqrt;
      const Scalar skew = h / (2 * sqrt(Scalar(3)));
      const Eigen::Index c = x.cols();
      const auto K_1 = K.leftCols(c), K_2 = K.rightCols(c);
      middle_ = x + (h / 4) * (K_1 + K_2);
      point_ = middle_ - skew * K_2;
      system_.field(point_, slope_);
      g.leftCols(c) = slope_;
      point_ = middle_ + skew * K_1;
      system_.field(point_, slope_);
      g.rightCols(c) = slope_;
    }

    void displacement(const Point& x, const Matrix<Scalar>& K, Point& dx) {
      dx = (h_ / 2) * (K.leftCols(x.cols()) + K.rightCols(x.cols()));
    }

   private:
    using Base = ImplicitMap<Map, S, arithmetic>;
    using Base::h_;
    using Base::system_;
    Point point_, slope_, middle_;
  };
};

}  // namespace stiefel
