#include <gtest/gtest.h>

#include "stiefel/error_estimate.h"
#include "stiefel/simulation.h"
#include "tests/support/surveys/error_survey.h"
#include "tests/support/scenes/random_frame.h"

namespace stiefel {
namespace {

TEST(EstimatedError, OfTwoHundredScenesIsTheTrueOne) { testing::expect_estimates(10'001, 200); }

/// Two geodesics on V(2, 5) that start 1e-18 apart are far from each other at t = 600. So are two
/// solutions in extended precision. The estimate is then missing, unless the budget allows
/// quadruple precision.
TEST(EstimatedError, IsNotToldOnceTheReferenceIsLostToChaos) {
  const testing::RandomFrame<double> frame(2, 5, 3, 30);
  SceneDescription d;
  d.system = "stiefel";
  d.method = MethodDescription{"variational", 6, {}, ""};
  d.inertia = {frame.lambda.begin(), frame.lambda.end()};
  d.initial = {{"Q", Block(frame.Q)}, {"S", Block(frame.S)}};
  d.step = 0.02;
  const Scene scene = Scene::resolve(d).value();
  const auto now = make_simulation(scene);
  ASSERT_TRUE(now->advance(500).reached());
  EXPECT_TRUE(estimate_error(scene, *now, 2e10, {}).attitude);
  ASSERT_TRUE(now->advance(29'500).reached());
  const ErrorEstimate late = estimate_error(scene, *now, 2e10, {});
  if (late.attitude) {
    EXPECT_LT(late.reference_error, 0.1) << late.reference;
    EXPECT_GT(*late.attitude, 0.01);
  } else {
    EXPECT_NE(late.missing.find("chaotic"), std::string::npos) << late.missing;
  }
}

}  // namespace
}  // namespace stiefel
