#pragma once

#include <boost/math/special_functions/ellint_2.hpp>
#include <cmath>
#include <numbers>

#include "engine/accuracy/reference.h"
#include "stiefel/scene.h"

namespace stiefel::testing {

/// A geodesic on V(1, 2), Λ = diag(λ_1, λ_2), λ_1 < λ_2: q = (cos φ, sin φ) runs along an ellipse
/// at constant speed, √λ_2 E(φ, k) = s_0 + ct, k² = 1 − λ_1/λ_2. Where q passes its flat side, S is
/// small and turns fast.
class OnAnEllipse {
 public:
  using Wide = long double;
  explicit OnAnEllipse(const Scene& scene)
      : lambda_(scene.inertia().cast<Wide>()),
        k_(std::sqrt(1 - lambda_(0) / lambda_(1))),
        half_(2 * std::sqrt(lambda_(1)) * boost::math::ellint_2(k_)) {
    const Eigen::Vector<Wide, 2> q = scene.Q().transpose().cast<Wide>(),
                                 v = scene.block("S").transpose().cast<Wide>().cwiseQuotient(
                                     lambda_);
    const Wide phi = std::atan2(q(1), q(0));
    start_ = length(phi);
    speed_ = slope(phi) * (q(0) * v(1) - q(1) * v(0)) / q.squaredNorm();
  }
  MotionState at(Wide t) const {
    const Wide s = start_ + speed_ * t, pi = std::numbers::pi_v<Wide>;
    // Half turns bracket φ; the bracket is halved until Newton's steps converge.
    Wide low = std::floor(s / half_) * pi, high = low + pi;
    for (int i = 0; i < 24; ++i) (length((low + high) / 2) < s ? low : high) = (low + high) / 2;
    Wide phi = (low + high) / 2;
    for (int i = 0; i < 4; ++i) phi -= (length(phi) - s) / slope(phi);
    MotionState state{Matrix<Wide>(1, 2), Matrix<Wide>(1, 2)};
    state.attitude << std::cos(phi), std::sin(phi);
    const Wide rate = speed_ / slope(phi);
    state.momentum << -rate * std::sin(phi) * lambda_(0), rate * std::cos(phi) * lambda_(1);
    return state;
  }

 private:
  Wide length(Wide phi) const { return std::sqrt(lambda_(1)) * boost::math::ellint_2(k_, phi); }
  Wide slope(Wide phi) const {
    return std::hypot(std::sqrt(lambda_(0)) * std::sin(phi), std::sqrt(lambda_(1)) * std::cos(phi));
  }
  Eigen::Vector<Wide, 2> lambda_;
  Wide k_, half_;  ///< the modulus, and the length of a half turn
  Wide start_ = 0, speed_ = 0;
};

/// A geodesic on V(1, 2) with Λ = diag(1, ratio), from the angle φ, with the velocity `speed` /
/// √ratio.
inline SceneDescription on_an_ellipse(double ratio, double angle, double speed, double step,
                                      double tolerance, int steps) {
  SceneDescription d;
  d.system = "stiefel";
  d.inertia = {1, ratio};
  const double c = std::cos(angle), s = std::sin(angle), scale = speed / std::sqrt(ratio);
  d.initial["Q"] = RowMatrix(Eigen::RowVector2d(c, s));
  d.initial["S"] = RowMatrix(Eigen::RowVector2d(-scale * s, scale * c * ratio));
  d.step = step;
  d.tolerance = tolerance;
  d.horizon = steps * step;
  return d;
}

}  // namespace stiefel::testing
