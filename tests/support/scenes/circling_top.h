#pragma once

#include <cmath>
#include <string>

#include "stiefel/scene.h"

namespace stiefel::testing {

inline constexpr long double circling_m1 = 0.5L, circling_m3 = 1.5L;

/// Returns the scene of a top with I = (1, 2, 3) and m = (circling_m1, 0, circling_m3), which
/// circles the third axis: m_2 = 0 at the multiples of 2K/p, K the complete elliptic integral.
inline SceneDescription circling_top(double step, const std::string& method, int order = 0) {
  SceneDescription scene;
  scene.system = "rigid_body";
  scene.step = step;
  scene.method.emplace().name = method;
  if (order > 0) scene.method->order = order;
  scene.inertia = {2, 1, 0};
  scene.initial["Q"] = RowMatrix(RowMatrix::Identity(3, 3));
  RowMatrix M(3, 3);
  M << 0, -static_cast<double>(circling_m3), 0, static_cast<double>(circling_m3), 0,
      -static_cast<double>(circling_m1), 0, static_cast<double>(circling_m1), 0;
  scene.initial["M"] = M;
  return scene;
}

/// Returns 2K/p in extended precision, with K by the arithmetic-geometric mean.
inline long double circling_half_period() {
  constexpr long double m1 = circling_m1, m3 = circling_m3;
  const long double p = m3 / 3, k2 = 3 * m1 * m1 / (m3 * m3);  // as (I3 - I2)(I3 - I1)/(I1 I2) = 1
  long double a = 1, b = std::sqrt(1 - k2);
  for (int i = 0; i < 10; ++i) {
    const long double mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
  }
  return std::acos(-1.0L) / a / p;
}

}  // namespace stiefel::testing
