#pragma once

#include <cmath>

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

/// The map of `splitting` (methods/splitting.h): m and the quaternion, which is 0 where the scene
/// has none, are turned about the principal axes one after the other.
template <class Scalar_>
class SplitBody3 {
 public:
  using Scalar = Scalar_;
  using S = RigidBody<So3<Scalar, true>>;
  using Point = typename S::State;
  using State = PlainState<Point>;
  static constexpr bool only_rotates = true;

  SplitBody3(const S& body, Scalar h, const MethodOptions& options)
      : arithmetic_(options.arithmetic),
        coarse_(half_step_over_I<Scalar>(body, h)),
        fine_(half_step_over_I<Extended<Scalar>>(body, h)) {}

  State start(const Point& x) const { return State{Accumulator<Point>(x, arithmetic_)}; }

  RunStatus step(State& state) const {
    Accumulator<Point>& sum = state.x;
    if (!sum.compensated) {
      Point x = sum.value;
      strang(x, coarse_);
      if (!x.allFinite()) return {Outcome::not_finite, std::nullopt};
      x.template head<4>() *= (3 - x.template head<4>().squaredNorm()) / 2;
      sum.value = x;
      return {};
    }
    Eigen::Matrix<Extended<Scalar>, 7, 1> x;
    for (Eigen::Index i = 0; i < 7; ++i) x(i) = sum.with_carry(i, 0);
    strang(x, fine_);
    if (!x.allFinite()) return {Outcome::not_finite, std::nullopt};
    for (Eigen::Index i = 0; i < 7; ++i) sum.add_with_carry(i, 0, x(i) - sum.with_carry(i, 0));
    return {};
  }

  std::optional<double> largest_step(const State&, double) const { return std::nullopt; }

 private:
  /// Returns (h/2)/I.
  template <class Working>
  static Vector3<Working> half_step_over_I(const S& body, Scalar h) {
    const PrincipalMoments3<Working> I(body.lambda());
    return Working(h) / 2 * I.moments.cwiseInverse();
  }

  template <class Working>
  static void strang(Eigen::Matrix<Working, 7, 1>& x, const Vector3<Working>& half_step_over_I) {
    const Vector3<Working>& rate = half_step_over_I;
    flow<0>(x, rate, Working(1) / 2);
    flow<1>(x, rate, Working(1) / 2);
    flow<2>(x, rate, Working(1));
    flow<1>(x, rate, Working(1) / 2);
    flow<0>(x, rate, Working(1) / 2);
  }

  /// Applies the flow of m_a²/(2I_a) over `part` of h: q ← q∘exp(½θ e_a), m ← exp(−θ ê_a) m.
  template <int a, class Working>
  static void flow(Eigen::Matrix<Working, 7, 1>& x, const Vector3<Working>& half_step_over_I,
                   Working part) {
    using std::cos, std::sin;
    constexpr int b = (a + 1) % 3, c = (a + 2) % 3;
    const Working half = part * half_step_over_I(a) * x(4 + a), sine = sin(half),
                  cosine = cos(half);
    const Working w = x(0), q_a = x(1 + a), q_b = x(1 + b), q_c = x(1 + c);
    x(0) = w * cosine - q_a * sine;
    x(1 + a) = q_a * cosine + w * sine;
    x(1 + b) = q_b * cosine + q_c * sine;
    x(1 + c) = q_c * cosine - q_b * sine;
    // Turns m by θ, with sin θ and 1 − cos θ.
    const Working m_b = x(4 + b), m_c = x(4 + c);
    x(4 + b) += 2 * sine * (cosine * m_c - sine * m_b);
    x(4 + c) -= 2 * sine * (cosine * m_b + sine * m_c);
  }

  Arithmetic arithmetic_;
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

template <class Scalar>
SplitBody3<Scalar> map_of(Splitting, const RigidBody<So3<Scalar, true>>& body, Scalar h,
                          const MethodOptions& options) {
  return {body, h, options};
}

template <class Space>
ImplicitMidpoint::Map<RigidBody<Space>, CayleyMidpoint<Space>> map_of(
    ImplicitMidpoint, const RigidBody<Space>& body, typename Space::Scalar h,
    const MethodOptions& options) {
  return {body, h, options};
}

/// For Λ of at most two values; bodies of scenes in three dimensions move by exact_body.cc.
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
    .where = "N = 3, or Lambda of at most two values", .takes = TurnedBody::has};

}  // namespace stiefel
