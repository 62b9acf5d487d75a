// The limit of the attempts of a method that chooses its own steps.
#include "server/sessions/attempts.h"

#include <gtest/gtest.h>

#include "engine/methods/adaptive.h"
#include "server/sessions/cursor.h"
#include "tests/server/flat_ellipsoid.h"

namespace stiefel::server {
namespace {

std::shared_ptr<Session> session_of(SceneDescription scene) {
  return std::make_shared<Session>("s", Scene::resolve(std::move(scene)).value(),
                                   std::make_shared<const Clock>(&std::chrono::steady_clock::now));
}

TEST(Attempts, TheMostIsThatOfTheMethod) {
  EXPECT_EQ(predicted_attempts(1e30, 1e-9), Adaptive::most_substeps);
  EXPECT_EQ(predicted_attempts(std::nan(""), 1e-9), Adaptive::most_substeps);
  EXPECT_EQ(predicted_attempts(0, 1e-9), 1);
}

TEST(Attempts, OfRigidBodiesAreAtMostThePredictedOnes) {
  for (const char* system : {"rigid_body", "symmetric_rigid_body", "mclachlan_scovel"})
    for (const int N : {3, 5})
      for (const double step : {0.01, 0.1, 1.0, 5.0})
        for (const double tolerance : {1e-6, 1e-9, 1e-12}) {
          SceneDescription scene =
              test::description({.system = system, .method = "adaptive", .dimension = N});
          scene.step = step;
          scene.method->tolerance = tolerance;
          if (system == std::string("mclachlan_scovel")) {
            scene.initial["B"] = scene.initial["M"];
            scene.initial.erase("M");
          }
          const auto session = session_of(std::move(scene));
          const auto motion = make_simulation(session->scene());
          ASSERT_TRUE(motion->advance(20).reached());
          const auto attempts = static_cast<double>(motion->map_steps());
          const double predicted = session->attempt_limit()->of(20) / AttemptLimit::margin;
          EXPECT_LE(attempts, 1.5 * predicted) << system << N << " " << step << " " << tolerance;
          EXPECT_GE(attempts, 0.1 * predicted) << system << N << " " << step << " " << tolerance;
        }
}

TEST(Attempts, OnlyAMethodThatChoosesItsStepsHasALimit) {
  const auto session = session_of(test::description());
  EXPECT_FALSE(session->attempt_limit());
  EXPECT_EQ(session->most_work(3, 10), session->work(3, 10));
}

TEST(Attempts, OfAnEnsembleAreThoseOfAllMembers) {
  SceneDescription many = test::description({.method = "adaptive"});
  const auto one = session_of(many);
  many.members = 5;
  for (auto& [name, block] : many.initial) {
    const RowMatrix values = block.values;
    block.values.resize(5 * values.rows(), values.cols());
    for (int b = 0; b < 5; ++b) block.values.middleRows(b * values.rows(), values.rows()) = values;
  }
  const auto five = session_of(std::move(many));
  EXPECT_DOUBLE_EQ(five->most_work(0, 10), 5 * one->most_work(0, 10));
  EXPECT_DOUBLE_EQ(five->work(0, 10), 5 * one->work(0, 10));
}

/// A call on a geodesic that turns so sharply that it takes several times the predicted attempts.
TEST(Attempts, ACursorStopsAtItsPriceAndTheNextOneGoesOn) {
  constexpr std::int64_t to = 400;
  const auto session = session_of(test::flat_ellipsoid());
  const double attempt = session->attempt_limit()->work;
  int calls = 0;
  for (std::int64_t before = 0; true; ++calls) {
    const double price = session->most_work(session->start_for(to), to);
    Cursor walk(*session, to);
    const std::int64_t tried = walk.simulation().map_steps();
    EXPECT_EQ(walk.start(), before) << "from the state that was reached";
    try {
      std::int64_t budget = to;
      EXPECT_TRUE(walk.advance(to, budget));
      EXPECT_EQ(test::saved(walk.simulation()), test::expected_state(session->scene(), to));
      break;
    } catch (const PriceReached& reached) {
      EXPECT_EQ(reached.step(), walk.step());
      EXPECT_EQ(reached.work(), price);
      EXPECT_LE(static_cast<double>(walk.simulation().map_steps() - tried) * attempt, price);
      EXPECT_GT(reached.step(), before);
      before = reached.step();
    }
  }
  EXPECT_GE(calls, 1);
  EXPECT_LE(calls, 3) << "the price learns what the steps take";
}

}  // namespace
}  // namespace stiefel::server
