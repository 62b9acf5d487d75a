// What a reply has of a scene, and the pages of a list.

#include "tests/server/harness.h"

namespace stiefel {
namespace {

v1::Scene body_scene() {
  v1::Scene scene;
  scene.set_system("rigid_body");
  scene.set_step(0.05);
  for (const double moment : {1.0, 2.0, 2.5}) scene.mutable_body()->add_moments(moment);
  for (const double omega : {0.1, 1.0, 0.1}) scene.mutable_body()->add_angular_velocity(omega);
  return scene;
}

TEST(Views, ASceneIsInAReplyOnRequest) {
  test::Harness harness;
  v1::CreateSessionRequest request;
  request.set_session_id("s");
  *request.mutable_scene() = body_scene();
  const auto create = [&] {
    grpc::ClientContext context;
    v1::CreateSessionResponse response;
    EXPECT_TRUE(harness.stub->CreateSession(&context, request, &response).ok());
    return response.session();
  };
  EXPECT_FALSE(create().has_scene());
  request.set_return_scene(true);
  const v1::Session resolved = create();
  EXPECT_TRUE(resolved.scene().has_method());
  EXPECT_EQ(resolved.scene().body().attitude_size(), 4);
  *request.mutable_scene() = resolved.scene();
  EXPECT_EQ(create().scene().DebugString(), resolved.scene().DebugString()) << "the same session";
}

TEST(Views, AConversionHasItsSceneOnRequest) {
  test::Harness harness;
  v1::ConvertRequest request;
  *request.mutable_scene() = body_scene();
  request.set_to("symmetric_rigid_body");
  const auto without = harness.convert(request);
  request.set_return_scene(true);
  const auto full = harness.convert(request);
  EXPECT_FALSE(without.has_scene());
  EXPECT_TRUE(full.scene().has_step());
  EXPECT_EQ(full.scene().system(), "symmetric_rigid_body");
  EXPECT_GT(without.margins_size(), 0);
  EXPECT_GT(full.margins_size(), 0);
  request.set_to("velocity");
  const auto velocity = harness.convert(request);
  ASSERT_EQ(velocity.blocks_size(), 2);
  EXPECT_EQ(velocity.blocks(1).name(), "Qdot");
  EXPECT_EQ(velocity.blocks(1).value().data().size(), 72u);
  EXPECT_FALSE(velocity.has_scene());
}

TEST(Lists, ClampTheSizeOfAPage) {
  test::Harness harness({.max_sessions = 1200});
  for (int i = 0; i < 1100; ++i) harness.create(std::to_string(i), test::wire_scene());
  v1::ListSessionsRequest request;
  request.set_page_size(4'000'000'000);
  grpc::ClientContext context;
  v1::ListSessionsResponse response;
  ASSERT_TRUE(harness.stub->ListSessions(&context, request, &response).ok());
  EXPECT_EQ(response.sessions_size(), 1000);
  EXPECT_FALSE(response.next_page_token().empty());
}

}  // namespace
}  // namespace stiefel
