#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/frames/geodesics/geodesic_series.h"
#include "stiefel/conjugate_points.h"
#include "tests/support/scenes/random_ray.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using std::numbers::pi;
using testing::norm;
using testing::random_ray;

TEST(InjectivityRadius, IsPiInTheEuclideanMetric) {
  for (const auto& [n, N] : {std::pair<Index, Index>(1, 3), {2, 4}, {3, 5}, {2, 3}}) {
    RadiusProblem problem{VectorXd::Ones(N), n};
    problem.starts = 2;
    const auto found = injectivity_radius(problem);
    ASSERT_TRUE(found && found->status.reached());
    EXPECT_NEAR(found->upper, pi, 1e-9);
    EXPECT_NEAR(found->lower, pi, 1e-14);
  }
  const auto body = injectivity_radius({VectorXd::Ones(3), 3, 1, 2});
  ASSERT_TRUE(body);
  EXPECT_NEAR(body->upper, std::numbers::sqrt2 * pi, 1e-9);
  EXPECT_NEAR(body->lower, std::numbers::sqrt2 * pi, 1e-14);
}

/// Where the bound is attained, the radius that is found lies on either side of it by its error.
TEST(InjectivityRadius, IsNotBelowItsProvenBound) {
  for (const double scale : {0.1, 1.0, 3.7, 1e4})
    for (const Index n : {1, 2, 3}) {
      const auto found = injectivity_radius({scale * VectorXd::Ones(3), n, 1, 2});
      ASSERT_TRUE(found && found->status.reached());
      EXPECT_GE(found->upper, found->lower) << n << " " << scale;
      EXPECT_GE(found->least_conjugate, found->lower) << n << " " << scale;
      EXPECT_GE(found->least_loop, found->lower) << n << " " << scale;
      EXPECT_NEAR(found->upper, found->lower, 1e-9 * found->lower) << n << " " << scale;
    }
}

TEST(InjectivityRadius, HasAWitness) {
  for (const auto& [n, N] : {std::pair<Index, Index>(1, 3), {2, 4}, {3, 3}}) {
    for (const double ratio : {2.0, 10.0}) {
      const VectorXd lambda = VectorXd::LinSpaced(N, 1, ratio);
      const auto found = injectivity_radius({lambda, n, 1, 3});
      ASSERT_TRUE(found && found->status.reached());
      EXPECT_LE(found->lower, found->upper);
      EXPECT_NEAR(norm(lambda, found->Qdot), 1, 1e-12);
      EXPECT_EQ(found->upper, std::min(found->least_conjugate, found->least_loop));
      if (found->witness == RadiusWitness::closed_geodesic) {
        const auto end = geodesic_end(lambda, found->Q, 2 * found->upper * found->Qdot);
        EXPECT_LE((*end - found->Q).cwiseAbs().maxCoeff(), 1e-10);
      } else {
        const auto points =
            conjugate_points({lambda, found->Q, found->Qdot, found->upper * (1 + 1e-8)});
        ASSERT_TRUE(points);
        ASSERT_EQ(points->points.size(), 1U);
        EXPECT_NEAR(points->points[0].time, found->upper, 1e-10);
      }
    }
  }
}

/// A turn about the axis of the least moment closes after 2π, and is half as long as the way to the
/// nearest conjugate point of a symmetric body, τ ≥ π/2, or shorter.
TEST(InjectivityRadius, OfSymmetricBodiesIsHalfATurnAboutTheAxisOfTheLeastMoment) {
  for (const double I_3 : {0.05, 0.3, 1.6}) {
    const VectorXd lambda = (VectorXd(3) << I_3 / 2, I_3 / 2, 1 - I_3 / 2).finished();
    const auto found = injectivity_radius({lambda, 3, 1, 4});
    ASSERT_TRUE(found);
    EXPECT_EQ(found->witness, RadiusWitness::closed_geodesic);
    EXPECT_NEAR(found->upper, pi * std::sqrt(std::min(1.0, I_3)), 1e-9);
    EXPECT_GE(found->least_conjugate, pi);
  }
}

TEST(Connect, ProvesWhatTheInjectivityBoundProves) {
  const VectorXd lambda = VectorXd::LinSpaced(5, 1, 1.5);
  const Index n = 2;
  int proved = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    GeodesicRay ray = random_ray(lambda, n, 1, seed);
    const double bound = injectivity_bound(lambda, n), length = (seed % 2 ? 0.98 : 1.15) * bound;
    const TwoPointProblem problem{
        .inertia = lambda, .Q_0 = ray.Q, .Q_T = *geodesic_end(lambda, ray.Q, length * ray.Qdot)};
    const auto joined = connect(problem);
    ASSERT_TRUE(joined);
    const double found = std::sqrt(2 * joined->energy);
    EXPECT_EQ(joined->shortest == Shortest::yes, found <= bound);
    proved += joined->shortest == Shortest::yes;
    if (found <= bound) {
      EXPECT_NEAR(found, length, 1e-10);
    }
  }
  EXPECT_GE(proved, 5);
}

}  // namespace
}  // namespace stiefel
