#include "server/sessions/step_kind.h"

#include <gtest/gtest.h>

#include "server/sessions/server_session.h"
#include "tests/server/scene_cases.h"
#include "tests/support/scenes/ensemble_of.h"

namespace stiefel::server {
namespace {

std::shared_ptr<Session> session_of(SceneDescription scene) {
  return std::make_shared<Session>("s", Scene::resolve(std::move(scene)).value(),
                                   std::make_shared<const Clock>(&std::chrono::steady_clock::now));
}

SceneDescription scene(int N, const char* method, double step) {
  SceneDescription out = test::description({.method = method, .dimension = N});
  out.step = step;
  return out;
}

TEST(StepKind, AStepWithinTheTableOfPricesIsAsShortAsItSays) {
  for (const char* method : {"variational", "gauss4", "implicit_midpoint", "rk4"})
    for (const int N : {3, 8}) {
      const StepKind kind = session_of(scene(N, method, 1e-3))->step_kind();
      EXPECT_EQ(kind.kind, JobKind::brief) << method;
      EXPECT_FALSE(kind.unpredictable) << method;
    }
}

TEST(StepKind, AnIterationOverALongStepMayTakeLong) {
  for (const char* method : {"variational", "gauss4", "implicit_midpoint"})
    for (const int N : {3, 5, 8})
      for (const double step : {1e2, 1e6, 1e12}) {
        const StepKind kind = session_of(scene(N, method, step))->step_kind();
        EXPECT_EQ(kind.kind, JobKind::unsliced) << method << " N = " << N << " h = " << step;
        EXPECT_TRUE(kind.unpredictable) << method << " N = " << N << " h = " << step;
      }
}

TEST(StepKind, AnExplicitMethodTakesAsLongForEveryStep) {
  for (const char* method : {"rk4", "exact", "munthe_kaas4"}) {
    const StepKind kind = session_of(scene(3, method, 1e6))->step_kind();
    EXPECT_EQ(kind.kind, JobKind::brief) << method;
    EXPECT_FALSE(kind.unpredictable) << method;
  }
}

TEST(StepKind, AMethodThatChoosesItsStepsIsUnpredictable) {
  const StepKind kind = session_of(scene(3, "adaptive", 1e-3))->step_kind();
  EXPECT_EQ(kind.kind, JobKind::sliced);
  EXPECT_TRUE(kind.unpredictable);
  EXPECT_EQ(session_of(scene(3, "adaptive", 1e3))->step_kind().kind, JobKind::unsliced);
}

/// M passes from the large moment to the small one, and Ω with it grows a thousandfold.
TEST(StepKind, AMotionMayGrowFasterThanItsStart) {
  SceneDescription slow = scene(4, "gauss4", 0.1);
  slow.inertia = {1e-6, 1e-6, 1, 1};
  slow.initial["M"] = RowMatrix(RowMatrix::Zero(4, 4));
  slow.initial["M"].values(2, 3) = 1;
  slow.initial["M"].values(3, 2) = -1;
  EXPECT_TRUE(session_of(slow)->step_kind().unpredictable);
}

TEST(StepKind, AnEnsembleIsAsLongAsItsLongestMember) {
  std::vector<SceneDescription> bodies(3, scene(3, "gauss4", 1e-3));
  EXPECT_FALSE(session_of(testing::ensemble_of(bodies))->step_kind().unpredictable);
  bodies[1].initial["M"].values *= 1e6;
  EXPECT_TRUE(session_of(testing::ensemble_of(bodies))->step_kind().unpredictable);
}

}  // namespace
}  // namespace stiefel::server
