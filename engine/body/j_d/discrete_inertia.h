#pragma once

#include "engine/dense/so_4.h"
#include "engine/numbers/double_word.h"
#include "engine/numbers/pack.h"

namespace stiefel {

/// The constants of the discrete body for one step h: functions of λ_i + λ_j and λ_i − λ_j for the
/// pairs i ≠ j. In three dimensions the sums λ_i + λ_j are the principal moments.
template <class Scalar, int pairs>
struct DiscreteInertia {
  using Wide = Doubled<Scalar>;
  template <class T>
  using Vec = std::conditional_t<pairs == 3, Vector3<T>, Skew4<T>>;

  Mask<Scalar> positive;  ///< whether all λ_i + λ_j > 0
  Scalar near;            ///< a solution with |c|² below this is on the branch of the identity
  Eigen::Matrix<Scalar, pairs == 3 ? 3 : 4, 1, Eigen::DontAlign> lambda;
  Vec<Scalar> half_step_over_I;  ///< (h/2)/(λ_i + λ_j)
  Vec<Scalar> kappa;             ///< (λ_i − λ_j)/(λ_i + λ_j)
  Vec<Scalar> gain;              ///< (4/h)(λ_i − λ_j)
  Vec<Wide> moments_h;           ///< (λ_i + λ_j)/(h/2)
  Vec<Wide> differences_h;       ///< (λ_i − λ_j)/(h/2)

  /// Computes the constants from PrincipalMoments3 or PairSums4.
  template <class Pairs>
  DiscreteInertia(const Pairs& I, Scalar step)
      : near(static_cast<Scalar>(I.nearness())),
        lambda(I.lambda().template cast<Scalar>()),
        kappa(I.differences.cwiseQuotient(I.moments).template cast<Scalar>()) {
    using Given = typename decltype(I.moments)::Scalar;
    positive = I.moments.minCoeff() > Given(0);
    half_step_over_I = (Given(step) / 2 * I.moments.cwiseInverse()).template cast<Scalar>();
    gain = (4 / Given(step) * I.differences).template cast<Scalar>();
    moments_h = (I.moments / (Given(step) / 2)).template cast<Wide>();
    differences_h = (I.differences / (Given(step) / 2)).template cast<Wide>();
  }

  /// Packs the constants of several bodies, one body in each lane.
  template <class Body>
  explicit DiscreteInertia(const Body* bodies) {
    const auto lane = [&](auto&& number) {
      return Scalar::of_lanes([&](int k) { return number(bodies[k]); });
    };
    positive = Scalar(0) < lane([](const auto& I) { return I.positive ? 1 : -1; });
    near = lane([](const auto& I) { return I.near; });
    for (int i = 0; i < lambda.size(); ++i)
      lambda(i) = lane([i](const auto& I) { return I.lambda(i); });
    for (int i = 0; i < pairs; ++i) {
      half_step_over_I(i) = lane([i](const auto& I) { return I.half_step_over_I(i); });
      kappa(i) = lane([i](const auto& I) { return I.kappa(i); });
      gain(i) = lane([i](const auto& I) { return I.gain(i); });
      moments_h(i) = {lane([i](const auto& I) { return I.moments_h(i).high; }),
                      lane([i](const auto& I) { return I.moments_h(i).low; })};
      differences_h(i) = {lane([i](const auto& I) { return I.differences_h(i).high; }),
                          lane([i](const auto& I) { return I.differences_h(i).low; })};
    }
  }
};

// Code compiled for other instruction sets reads these objects, so their alignment must not exceed
// 16.
static_assert(alignof(DiscreteInertia<double, 3>) <= 16 &&
              alignof(DiscreteInertia<double, 6>) <= 16);

template <class Scalar>
using DiscreteInertia3 = DiscreteInertia<Scalar, 3>;
template <class Scalar>
using DiscreteInertia4 = DiscreteInertia<Scalar, 6>;

}  // namespace stiefel
