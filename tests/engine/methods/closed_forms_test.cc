#include <gtest/gtest.h>

#include "engine/dense/orthogonal.h"
#include "engine/frame/stiefel.h"
#include "stiefel/simulation.h"
#include "tests/support/exact_motion.h"
#include "tests/support/integrate.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

constexpr double step_size = 0.01;

SceneDescription exactly(SceneDescription d) {
  d.method = MethodDescription{"exact", {}, {}, ""};
  return d;
}

SceneDescription body(const std::vector<double>& lambda, unsigned seed) {
  const testing::RandomBody random(static_cast<int>(lambda.size()), seed);
  auto d = testing::description(random, step_size, "exact");
  d.inertia = lambda;
  return exactly(d);
}

SceneDescription frames(int n, int N, unsigned seed) {
  const testing::RandomFrame<double> frame(n, N, seed, 1);
  SceneDescription d;
  d.system = "stiefel";
  d.inertia.assign(static_cast<std::size_t>(N), 2);
  d.initial["Q"] = frame.Q;
  d.initial["S"] = frame.S;
  d.step = step_size;
  return exactly(d);
}

TEST(TwoValuedBody, IsTheMotion) {
  using Inertia = std::vector<double>;
  for (const auto& lambda :
       {Inertia{1, 1, 1, 1}, {1, 2.5, 1, 2.5, 1}, {3, 0.1, 0.1, 0.1}, {-0.2, 1, 1, 1, 1, 1}}) {
    const Scene scene = Scene::resolve(body(lambda, 3)).value();
    const auto simulation = make_simulation(scene);
    ASSERT_TRUE(simulation->advance(300).reached());
    const auto exact =
        testing::exact_motion(scene.inertia(), scene.Q(), scene.M(), 300 * step_size);
    EXPECT_LT((simulation->get("Q") - exact.Q).norm(), 1e-14);
    EXPECT_LT((simulation->get("M") - exact.M).norm(), 1e-14 * exact.M.norm());
  }
}

TEST(IsotropicGeodesic, AreTheGeodesics) {
  for (const auto& [n, N] : {std::pair{1, 3}, {2, 5}, {3, 5}, {3, 4}, {4, 4}}) {
    const Scene scene = Scene::resolve(frames(n, N, 3)).value();
    const auto simulation = make_simulation(scene);
    ASSERT_TRUE(simulation->advance(300).reached());
    Eigen::MatrixXd x(2 * n, N);
    x << scene.Q(), scene.block("S");
    const Stiefel<long double> system(scene.inertia().cast<long double>(), n);
    const Eigen::MatrixXd exact = testing::flow(system, x, 300 * step_size);
    EXPECT_LT((simulation->get("Q") - exact.topRows(n)).norm(), 1e-14) << n << " " << N;
    EXPECT_LT((simulation->get("S") - exact.bottomRows(n)).norm(), 3e-14) << n << " " << N;
  }
}

/// Any state takes one evaluation, and its bits do not depend on the states before.
TEST(ClosedForms, GoAnywhereAtOnce) {
  for (const auto& d : {body({1, 2.5, 1, 2.5, 1}, 3), frames(2, 5, 3)}) {
    const Scene scene = Scene::resolve(d).value();
    const auto far = make_simulation(scene), by_way = make_simulation(scene);
    ASSERT_TRUE(far->advance(1'000'000'000'000).reached());
    ASSERT_TRUE(by_way->advance(17).reached());
    ASSERT_TRUE(by_way->advance(1'000'000'000'000 - 17).reached());
    EXPECT_EQ(far->get("Q"), by_way->get("Q"));
    EXPECT_LT(*far->orthogonality(), 1e-15);
  }
}

TEST(ClosedForms, AreRefusedWhereThereAreNone) {
  EXPECT_FALSE(Scene::resolve(body({1, 2, 3, 3}, 3)));
  const testing::RandomFrame<double> frame(2, 5, 3);
  auto d = frames(2, 5, 3);
  d.inertia.assign(frame.lambda.begin(), frame.lambda.end());
  d.initial["S"] = frame.S;
  const auto scene = Scene::resolve(d);
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().front().field, "method.name");
  EXPECT_EQ(scene.error().front().rule,
            "is only for Lambda a multiple of the identity; variational takes every Lambda");
}

}  // namespace
}  // namespace stiefel
