#include "stiefel/simulation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "stiefel/diagnosis.h"
#include "tests/support/exact_motion.h"
#include "tests/support/saved.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

using testing::RandomBody;
using testing::saved;

class EveryMethod : public ::testing::TestWithParam<std::tuple<int, std::string>> {};

TEST_P(EveryMethod, SubstepsAreSmallerSteps) {
  const auto [N, method] = GetParam();
  if (method.empty()) GTEST_SKIP() << "a discrete system has no substeps";
  SceneDescription d = testing::description(RandomBody(N, 3), 0.125, method);
  const auto small = make_simulation(Scene::resolve(d).value());
  d.step = 1;
  d.method->substeps = 8;
  const auto large = make_simulation(Scene::resolve(d).value());
  ASSERT_TRUE(small->advance(80).reached());
  ASSERT_TRUE(large->advance(10).reached());
  EXPECT_EQ(saved(*small), saved(*large));
}

TEST_P(EveryMethod, MomentumAloneMovesAsWithTheFrame) {
  const auto [N, method] = GetParam();
  SceneDescription d = testing::description(RandomBody(N, 5), 0.1, method);
  const auto both = make_simulation(Scene::resolve(d).value());
  d.initial.erase("Q");
  const Scene scene = Scene::resolve(d).value();
  const auto alone = make_simulation(scene);
  EXPECT_EQ(alone->fields()[0].name, "M");
  EXPECT_EQ(alone->block_count(), 1u);
  ASSERT_TRUE(both->advance(50).reached());
  ASSERT_TRUE(alone->advance(50).reached());
  EXPECT_LT((both->get("M") - alone->get("M")).norm(), 1e-14);
  EXPECT_FALSE(diagnose(scene, *alone).orthogonality);
}

INSTANTIATE_TEST_SUITE_P(Scenes, EveryMethod,
                         ::testing::Combine(::testing::Values(2, 3, 5),
                                            ::testing::Values("", "variational", "rk4",
                                                              "munthe_kaas4")));

TEST(Simulation, ReflectedFramesMoveToo) {
  RandomBody body(3, 2);
  body.Q.row(0) = -body.Q.row(0);
  const auto exact = testing::exact_motion(body.lambda, body.Q, body.M, 1);
  const auto simulation =
      make_simulation(Scene::resolve(testing::description(body, 0.002, "munthe_kaas4")).value());
  ASSERT_TRUE(simulation->advance(500).reached());
  EXPECT_LT((simulation->get("Q") - exact.Q).norm(), 1e-10);
}

TEST(Simulation, TellsThatTheControllerHasNoSubstepsLeft) {
  const Scene scene =
      Scene::resolve(testing::description(RandomBody(3, 1), 1e7, "adaptive")).value();
  RunStatus status = make_simulation(scene)->advance(1);
  ASSERT_EQ(status.outcome, Outcome::solver_stalled);
  EXPECT_TRUE(to_sentence(status, scene).starts_with("the step-size control of adaptive"));
  status.member = 7;
  EXPECT_TRUE(
      to_sentence(status, scene).starts_with("member 7: the step-size control of adaptive"));
}

/// The largest step that a run with substeps names works from the last good state, and one longer
/// by 5 % does not, for motions that leave the domain in any of their substeps.
void expect_largest_step(SceneDescription d, int& seen) {
  const auto simulation = make_simulation(Scene::resolve(d).value());
  const RunStatus status = simulation->advance(30);
  if (status.outcome != Outcome::left_domain || !status.largest_step) return;
  ++seen;
  const auto works = [&](double h) {
    SceneDescription from_there = d;
    from_there.step = h * d.method->substeps.value();
    for (auto& [name, block] : from_there.initial) block = simulation->get(name);
    return make_simulation(Scene::resolve(from_there).value())->advance(1).reached();
  };
  SCOPED_TRACE(::testing::Message() << d.system << " " << d.method->order.value() << " "
                                    << d.method->substeps.value() << " " << *status.largest_step);
  EXPECT_TRUE(works(*status.largest_step));
  EXPECT_FALSE(works(1.05 * *status.largest_step));
}

TEST(Simulation, TheLargestStepIsThatOfAllSubsteps) {
  int seen = 0;
  for (const int order : {2, 4, 6, 8})
    for (const int substeps : {1, 2, 4, 7})
      for (unsigned seed = 1; seed <= 4; ++seed) {
        const double h = 0.1 * std::pow(1.5, seed);
        const MethodDescription method = {"variational", order, substeps, ""};
        SceneDescription frame;
        frame.system = "stiefel";
        frame.method = method;
        frame.inertia = {1, 5, 2, 0.5};
        frame.initial["Q"] = Eigen::MatrixXd(Eigen::MatrixXd::Identity(2, 4));
        Eigen::MatrixXd S(2, 4);  // tangent: (S_12 / λ_2) + (S_21 / λ_1) = 0
        S << 0, 5, 1.0 * seed, -1, -1, 0, 2, 0.5;
        frame.initial["S"] = S;
        frame.step = h * substeps;
        expect_largest_step(frame, seen);

        SceneDescription point = frame;
        point.system = "ellipsoid";
        point.initial.clear();
        point.initial["q"] = Eigen::MatrixXd(Eigen::MatrixXd::Identity(1, 4));
        point.initial["qdot"] = Eigen::MatrixXd(Eigen::RowVector4d(0, 2, 1, 0.3 * seed));
        expect_largest_step(point, seen);

        SceneDescription body =
            testing::description(RandomBody(3 + seed % 3, seed), h, "variational");
        body.method = method;
        body.step = 2 * h * substeps;
        expect_largest_step(body, seen);
      }
  EXPECT_GT(seen, 60);
}

}  // namespace
}  // namespace stiefel
