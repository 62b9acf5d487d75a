// The predicted work of a step of `adaptive`, which chooses its own substeps.
#include <gtest/gtest.h>

#include "server/sessions/server_session.h"
#include "stiefel/price.h"
#include "tests/server/scene_cases.h"

namespace stiefel::server {
namespace {

std::shared_ptr<Session> session_of(SceneDescription scene) {
  return std::make_shared<Session>(Scene::resolve(std::move(scene)).value());
}

/// Rigid bodies try at most 1.5 times as many substeps as predicted.
TEST(StepWork, OfRigidBodiesIsThatOfTheirSubsteps) {
  constexpr double steps = 20;
  for (const char* system : {"rigid_body", "symmetric_rigid_body"})
    for (const int N : {3, 5})
      for (const double step : {0.01, 0.1, 1.0, 5.0})
        for (const double tolerance : {1e-6, 1e-9, 1e-12}) {
          SceneDescription scene =
              test::description({.system = system, .method = "adaptive", .dimension = N});
          scene.step = step;
          scene.method->tolerance = tolerance;
          const auto session = session_of(std::move(scene));
          const auto motion = make_simulation(session->scene());
          ASSERT_TRUE(motion->advance(steps).reached());
          const double taken =
              static_cast<double>(motion->map_steps()) * step_weight(session->scene());
          EXPECT_LE(taken, 1.5 * steps * session->step_work()) << system << N << " " << step;
          EXPECT_GE(taken, 0.1 * steps * session->step_work()) << system << N << " " << step;
        }
}

TEST(StepWork, OfAnEnsembleIsThatOfAllMembers) {
  SceneDescription many = test::description({.method = "adaptive"});
  const auto one = session_of(many);
  many.members = 5;
  for (auto& [name, block] : many.initial) {
    const RowMatrix values = block.values;
    block.values.resize(5 * values.rows(), values.cols());
    for (int b = 0; b < 5; ++b) block.values.middleRows(b * values.rows(), values.rows()) = values;
  }
  EXPECT_DOUBLE_EQ(session_of(std::move(many))->step_work(), 5 * one->step_work());
}

}  // namespace
}  // namespace stiefel::server
