// Callers who leave while the simulation of an ensemble is made: each is answered, and nothing
// stays behind.
#include <thread>

#include "tests/server/harness.h"

namespace stiefel {
namespace {

using namespace std::chrono_literals;

v1::Scene bodies(std::uint32_t members) {
  v1::Scene scene = test::wire_scene();
  scene.clear_initial();
  scene.clear_inertia();
  for (const double moment : {1.0, 2.0, 2.5}) scene.mutable_body()->add_moments(moment);
  for (std::uint32_t b = 0; b < 3 * members; ++b)
    scene.mutable_body()->add_angular_velocity(0.3 + 1e-4 * b);
  scene.set_members(members);
  return scene;
}

TEST(Cancel, WhileTheSimulationOfAnEnsembleIsMade) {
  constexpr std::uint32_t members = 2000;
  test::Harness harness({.threads = 2});
  harness.create("s", bodies(members));
  int cancelled = 0;
  for (int i = 0; i < 40; ++i) {
    grpc::ClientContext context;
    const std::jthread leaves([&context, i] {
      std::this_thread::sleep_for(i % 20 * 500us);
      context.TryCancel();
    });
    // A fork goes on to convert its ensemble, so that it is cancelled later too.
    v1::ForkSessionRequest request;
    request.set_session_id("t");
    request.set_from_session_id("s");
    request.set_system("symmetric_rigid_body");
    v1::ForkSessionResponse response;
    const auto code = harness.stub->ForkSession(&context, request, &response).error_code();
    cancelled += code == grpc::CANCELLED;
    EXPECT_TRUE(code == grpc::CANCELLED || code == grpc::OK) << code;
  }
  EXPECT_GT(cancelled, 0);
  const auto reached = harness.step("s", 1);
  EXPECT_EQ(reached.sample().step(), 1);
  EXPECT_EQ(reached.computed_steps(), 1);
}

}  // namespace
}  // namespace stiefel
