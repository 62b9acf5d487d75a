#pragma once

#include <cmath>

#include "engine/body/exact/euler_top.h"
#include "engine/body/exact/turned_body.h"
#include "engine/body/moser_veselov.h"
#include "engine/body/preprocessed_moser_veselov.h"
#include "engine/body/rigid_body.h"
#include "engine/dense/cayley_midpoint.h"
#include "engine/dense/principal_moments_3.h"
#include "engine/methods/exact.h"
#include "engine/methods/implicit_midpoint.h"
#include "engine/methods/matrix_system.h"
#include "engine/methods/method.h"
#include "engine/methods/preprocessed_variational.h"
#include "engine/methods/splitting.h"
#include "engine/methods/variational.h"

namespace stiefel {

/// The map of `splitting` (methods/splitting.h): m and the quaternion are turned about the
/// principal axes one after the other.
template <class Scalar_, bool frame>
class SplitBody3 {
 public:
  using Scalar = Scalar_;
  using S = RigidBody<So3<Scalar, frame>>;
  using Point = typename S::State;
  using State = PlainState<Point>;
  static constexpr bool only_rotates = true;

  SplitBody3(const S& body, Scalar h, const MethodOptions& options)
      : arithmetic_(options.arithmetic),
        moves_frame_(frame && body.has_frame()),
        coarse_(half_step_over_I<Scalar>(body, h)),
        fine_(half_step_over_I<Extended<Scalar>>(body, h)) {}

  State start(const Point& x) const { return State{Accumulator<Point>(x, arithmetic_)}; }

  RunStatus step(State& state) const {
    return moves_frame_ ? step_of<frame>(state.x) : step_of<false>(state.x);
  }

  std::optional<double> largest_step(const State&, double) const { return std::nullopt; }

 private:
  /// (q; m), or m alone.
  template <class Working, bool with_q>
  using Turned = Eigen::Matrix<Working, with_q ? 7 : 3, 1>;

  template <bool with_q>
  RunStatus step_of(Accumulator<Point>& sum) const {
    constexpr Eigen::Index size = with_q ? 7 : 3, first = Point::RowsAtCompileTime - size;
    if (!sum.compensated) {
      Turned<Scalar, with_q> x = sum.value.template tail<size>();
      strang<with_q>(x, coarse_);
      if (!x.allFinite()) return {Outcome::not_finite, std::nullopt};
      if constexpr (with_q) x.template head<4>() *= (3 - x.template head<4>().squaredNorm()) / 2;
      sum.value.template tail<size>() = x;
      return {};
    }
    Turned<Extended<Scalar>, with_q> x;
    for (Eigen::Index i = 0; i < size; ++i) x(i) = sum.with_carry(first + i, 0);
    strang<with_q>(x, fine_);
    if (!x.allFinite()) return {Outcome::not_finite, std::nullopt};
    for (Eigen::Index i = 0; i < size; ++i)
      sum.add_with_carry(first + i, 0, x(i) - sum.with_carry(first + i, 0));
    return {};
  }

  /// Returns (h/2)/I.
  template <class Working>
  static Vector3<Working> half_step_over_I(const S& body, Scalar h) {
    const PrincipalMoments3<Working> I(body.lambda());
    return Working(h) / 2 * I.moments.cwiseInverse();
  }

  template <bool with_q, class Working>
  static void strang(Turned<Working, with_q>& x, const Vector3<Working>& half_step_over_I) {
    const Vector3<Working>& rate = half_step_over_I;
    flow<0, with_q>(x, rate, Working(1) / 2);
    flow<1, with_q>(x, rate, Working(1) / 2);
    flow<2, with_q>(x, rate, Working(1));
    flow<1, with_q>(x, rate, Working(1) / 2);
    flow<0, with_q>(x, rate, Working(1) / 2);
  }

  /// Applies the flow of m_a²/(2I_a) over `part` of h: q ← q∘exp(½θ e_a), m ← exp(−θ ê_a) m.
  template <int a, bool with_q, class Working>
  static void flow(Turned<Working, with_q>& x, const Vector3<Working>& half_step_over_I,
                   Working part) {
    using std::cos, std::sin;
    constexpr int b = (a + 1) % 3, c = (a + 2) % 3, first = with_q ? 4 : 0;
    const Working half = part * half_step_over_I(a) * x(first + a), sine = sin(half),
                  cosine = cos(half);
    if constexpr (with_q) {
      const Working w = x(0), q_a = x(1 + a), q_b = x(1 + b), q_c = x(1 + c);
      x(0) = w * cosine - q_a * sine;
      x(1 + a) = q_a * cosine + w * sine;
      x(1 + b) = q_b * cosine + q_c * sine;
      x(1 + c) = q_c * cosine - q_b * sine;
    }
    // Turns m by θ, with sin θ and 1 − cos θ.
    const Working m_b = x(first + b), m_c = x(first + c);
    x(first + b) += 2 * sine * (cosine * m_c - sine * m_b);
    x(first + c) -= 2 * sine * (cosine * m_b + sine * m_c);
  }

  Arithmetic arithmetic_;
  bool moves_frame_;
  Vector3<Scalar> coarse_;          ///< (h/2)/I
  Vector3<Extended<Scalar>> fine_;  ///< (h/2)/I
};

// The maps of methods that are made for the left-invariant rigid body.

template <class Space>
auto map_of(Variational, const RigidBody<Space>& body, typename Space::Scalar h,
            const MethodOptions& options) {
  return composed(
      [body](typename Space::Scalar stage, Arithmetic arithmetic) -> MoserVeselov<Space> {
        if constexpr (HasMatrixStates<RigidBody<Space>>)
          return {body.lambda(), stage, arithmetic};
        else
          return {body.lambda(), stage, arithmetic, body.has_frame()};
      },
      h, options);
}

template <class Scalar, bool frame>
PreprocessedMoserVeselov<Scalar, frame> map_of(PreprocessedVariational,
                                               const RigidBody<So3<Scalar, frame>>& body, Scalar h,
                                               const MethodOptions& options) {
  return {body.lambda(), h, options.arithmetic, options.order, body.has_frame()};
}

template <class Scalar, bool frame>
SplitBody3<Scalar, frame> map_of(Splitting, const RigidBody<So3<Scalar, frame>>& body, Scalar h,
                                 const MethodOptions& options) {
  return {body, h, options};
}

template <class Space>
ImplicitMidpoint::Map<RigidBody<Space>, CayleyMidpoint<Space>> map_of(
    ImplicitMidpoint, const RigidBody<Space>& body, typename Space::Scalar h,
    const MethodOptions& options) {
  return {body, h, options};
}

/// Bodies of scenes in three dimensions have more digits of Λ and M (exact_body.cc).
template <class Scalar, bool frame>
auto map_of(Exact, const RigidBody<So3<Scalar, frame>>& body, Scalar h, const MethodOptions&) {
  using Wide = Extended<Scalar>;
  using Point = typename So3<Scalar, frame>::State;
  return closed_form_map<Point>(
      [body](const Point& start) {
        return EulerTop<Wide, frame>(PrincipalMoments3<Wide>(body.lambda()),
                                     start.template cast<Wide>());
      },
      h);
}

template <class Scalar>
auto map_of(Exact, const RigidBody<SoN<Scalar>>& body, Scalar h, const MethodOptions&) {
  using Wide = Extended<Scalar>;
  return closed_form_map<Matrix<Scalar>>(
      [body](const Matrix<Scalar>& start) {
        return TwoValuedBody<Wide>(body.lambda().template cast<Wide>(),
                                   start.template cast<Wide>());
      },
      h);
}
template <class Scalar>
inline constexpr Declared declared<Exact, RigidBody<SoN<Scalar>>> = {
    .where = "N = 3, or Lambda of at most two values", .takes = BodyRotation::has};

}  // namespace stiefel
