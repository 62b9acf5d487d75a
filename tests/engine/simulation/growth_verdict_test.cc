#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "engine/dense/decompositions.h"
#include "engine/growth/growth.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;

/// Returns the growth of four vectors beside the motion of H = (p² + x² + y²)/2 + x²y − y³/3
/// [HenonHeiles1964] from x = 0, y, p_y = 0, over a time of 10⁴. Leapfrog steps and their
/// derivative are written out here, so that nothing but the growth and its verdict is the engine's.
Growth henon_heiles(double energy, double y) {
  constexpr double h = 0.05;
  constexpr int steps = 200'000, interval = 20;
  double x = 0, p_x = std::sqrt(2 * (energy - y * y / 2 + y * y * y / 3)), p_y = 0;
  Dense V = Dense::Identity(4, 4);  // rows δx, δy, δp_x, δp_y
  Growth growth(4);
  for (int k = 1; k <= steps; ++k) {
    const auto drift = [&] {
      x += h / 2 * p_x;
      y += h / 2 * p_y;
      V.topRows(2) += h / 2 * V.bottomRows(2);
    };
    drift();
    p_x -= h * (x + 2 * x * y);
    p_y -= h * (y + x * x - y * y);
    Eigen::Matrix2d hessian;
    hessian << 1 + 2 * y, 2 * x, 2 * x, 1 - 2 * y;
    V.bottomRows(2) -= h * hessian * V.topRows(2);
    drift();
    if (k % interval != 0) continue;
    const Dense R = triangular_factor(V);
    const Eigen::Vector4d sign = R.diagonal().array().sign();
    growth.add(interval * h, sign.asDiagonal() * R);
    V = orthonormal_columns(V, 4) * sign.asDiagonal();
  }
  return growth;
}

struct Control {
  double energy, y;
  MotionKind kind;
};

/// Those whose sections are curves are regular: all at the energy 1/12, and at 1/6 the one from y =
/// 0.1. The others fill an area, which at 1/6 is almost everything.
constexpr std::array controls = {
    Control{1.0 / 12, -0.3, MotionKind::regular}, Control{1.0 / 12, -0.1, MotionKind::regular},
    Control{1.0 / 12, 0.1, MotionKind::regular},  Control{1.0 / 12, 0.25, MotionKind::regular},
    Control{1.0 / 8, -0.25, MotionKind::chaotic}, Control{1.0 / 6, -0.15, MotionKind::chaotic},
    Control{1.0 / 6, -0.1, MotionKind::chaotic},  Control{1.0 / 6, 0.1, MotionKind::regular},
};

TEST(GrowthVerdict, OfHenonAndHeilesIsTheirs) {
  for (const auto& [energy, y, kind] : controls) {
    const Growth growth = henon_heiles(energy, y);
    const Judgement found = judge_growth(growth, 1);
    EXPECT_EQ(found.kind, kind) << energy << ", " << y << ": " << found.reason;
  }
}

/// Motions of one chaotic area have one exponent.
TEST(GrowthVerdict, MotionsOfOneAreaHaveOneExponent) {
  const Growth one = henon_heiles(1.0 / 6, -0.1), other = henon_heiles(1.0 / 6, -0.15);
  EXPECT_NEAR(one.sums()(0) / one.time(), other.sums()(0) / other.time(),
              std::hypot(one.batch_means().errors(0), other.batch_means().errors(0)));
  EXPECT_GT(one.sums()(0) / one.time(), 3 * one.batch_means().errors(0));
}

}  // namespace
}  // namespace stiefel
