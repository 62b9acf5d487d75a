#pragma once

#include <array>

#include "engine/methods/adaptive.h"
#include "engine/rigid_body/exact/turned_body.h"
#include "engine/methods/exact.h"
#include "engine/methods/munthe_kaas4.h"
#include "engine/catalogue/methods/recommendation.h"
#include "stiefel/scene.h"

namespace stiefel {

// Recommendations that several systems share. tests/engine/long/recommendation_for_long_test.cc
// measures their bounds (recommendation.h).

/// Returns a recommendation of steps with error control. In steps longer than h||Omega|| = 0.5
/// rounding would exceed the tolerance of a single stride.
constexpr Recommendation with_error_control(double tolerance, double largest_h_omega = 0.5) {
  return {.method = Adaptive::traits.name,
          .order = Adaptive::traits.default_order,
          .tolerance = tolerance,
          .largest_h_omega = largest_h_omega};
}

/// Returns a recommendation for those scenes that `takes` accepts.
constexpr Recommendation restricted(std::string_view where, bool (*takes)(const Scene&),
                                    Recommendation to) {
  to.where = where;
  to.takes = takes;
  return to;
}

/// Whether a rigid body has a closed form.
inline bool has_closed_form(const Scene& scene) {
  return BodyRotation<long double>::has(scene.inertia());
}
inline constexpr Recommendation closed_form_of_body = {
    .where = "N = 3, or Lambda of at most two values",
    .takes = has_closed_form,
    .method = Exact::traits.name,
    .arithmetic = "compensated"};

/// Whether Omega is constant, so that a step by the exponential is exact.
inline bool turns_evenly(const Scene& scene) {
  const Eigen::VectorXd& lambda = scene.inertia();
  return lambda.size() == 2 || (lambda.array() == lambda(0)).all();
}
inline constexpr Recommendation at_constant_Omega = {
    .where = "N = 2, or Lambda a multiple of the identity",
    .takes = turns_evenly,
    .method = MuntheKaas4::traits.name,
    .order = MuntheKaas4::traits.default_order};

/// For bodies whose M is a product of the blocks; the error of M grows with the square of the time.
inline constexpr std::array for_products = {closed_form_of_body, with_error_control(5e-14)};
inline bool is_one_point(const Scene& scene) { return scene.Q().rows() == 1; }
/// For costates on V(n, N). At n = 1 the motion is integrable, and its condition stays small while
/// its speed varies up to the root of λ_max/λ_min.
inline constexpr std::array for_costates = {
    restricted("n = 1", is_one_point, with_error_control(5e-12, 0.15)),
    with_error_control(3e-11, 0.15)};

}  // namespace stiefel
