// A reply has only the fields that were filled in; merged into the caller's scene they give the
// resolved one.

#include "tests/server/harness.h"

namespace stiefel {
namespace {

v1::Session create(test::Harness& harness, const std::string& id, const v1::Scene& scene,
                   v1::SceneView view) {
  v1::CreateSessionRequest request;
  request.set_session_id(id);
  *request.mutable_scene() = scene;
  request.mutable_view()->set_scene(view);
  grpc::ClientContext context;
  v1::CreateSessionResponse response;
  const auto status = harness.stub->CreateSession(&context, request, &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return response.session();
}

v1::Session get(test::Harness& harness, const std::string& id, v1::SceneView view) {
  v1::GetSessionRequest request;
  request.set_session_id(id);
  request.mutable_view()->set_scene(view);
  grpc::ClientContext context;
  v1::GetSessionResponse response;
  EXPECT_TRUE(harness.stub->GetSession(&context, request, &response).ok());
  return response.session();
}

/// Each field that is there in the place of the other message's.
void put(const google::protobuf::Message& fields, google::protobuf::Message* into) {
  std::vector<const google::protobuf::FieldDescriptor*> there;
  fields.GetReflection()->ListFields(fields, &there);
  for (const auto* field : there) into->GetReflection()->ClearField(into, field);
  into->MergeFrom(fields);
}

/// The resolved scene, as a client puts it together from what it sent and what the reply has.
template <class Reply>
v1::Scene merged(v1::Scene scene, const Reply& reply) {
  v1::Scene filled_in = reply.scene();
  if (filled_in.has_body() && scene.has_body()) {
    put(filled_in.body(), scene.mutable_body());
    filled_in.clear_body();
  }
  put(filled_in, &scene);
  for (const std::string& name : reply.cleared())
    scene.GetReflection()->ClearField(&scene, v1::Scene::descriptor()->FindFieldByName(name));
  return scene;
}

v1::Scene body_scene() {
  v1::Scene scene;
  scene.set_system("rigid_body");
  scene.set_step(0.05);
  for (const double moment : {1.0, 2.0, 2.5}) scene.mutable_body()->add_moments(moment);
  for (const double omega : {0.1, 1.0, 0.1}) scene.mutable_body()->add_angular_velocity(omega);
  return scene;
}

v1::Scene chosen_scene() {
  v1::Scene scene = test::wire_scene();
  scene.clear_method();
  scene.set_tolerance(1e-3);
  scene.set_horizon(1);
  return scene;
}

TEST(Views, WhatWasSentWithWhatWasFilledInIsTheResolvedScene) {
  test::Harness harness;
  v1::Scene momentum = test::wire_scene();
  momentum.set_system("symmetric_rigid_body");
  int count = 0;
  for (const v1::Scene& given : {test::wire_scene(), body_scene(), chosen_scene(), momentum}) {
    const std::string id = std::to_string(++count);
    const v1::Session session = create(harness, id, given, v1::SCENE_VIEW_FILLED_IN);
    const v1::Scene full = get(harness, id, v1::SCENE_VIEW_FULL).scene();
    const v1::Scene resolved = merged(given, session);
    EXPECT_EQ(resolved.DebugString(), full.DebugString()) << id;
    // It is the same session wherever it is created, and nothing is left to be filled in.
    EXPECT_EQ(create(harness, id, resolved, v1::SCENE_VIEW_UNSPECIFIED).scene().ByteSizeLong(), 0u);
  }
}

TEST(Views, AForkIsShownAgainstTheSessionItComesFrom) {
  test::Harness harness;
  const v1::Scene old = create(harness, "old", body_scene(), v1::SCENE_VIEW_FULL).scene();
  harness.create("m", test::wire_scene());
  const auto fork = [&](const std::string& from, const std::string& id, const std::string& system) {
    v1::ForkSessionRequest request;
    request.set_from_session_id(from);
    request.set_session_id(id);
    request.set_from_step(100);
    if (!system.empty()) request.set_system(system);
    grpc::ClientContext context;
    v1::ForkSessionResponse response;
    const auto status = harness.stub->ForkSession(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.session();
  };
  const v1::Session same = fork("old", "a", "");
  EXPECT_FALSE(same.scene().has_method());
  EXPECT_TRUE(same.scene().inertia().empty());
  EXPECT_EQ(same.scene().body().moments_size(), 0);
  EXPECT_EQ(same.scene().body().attitude_size(), 4);
  EXPECT_EQ(merged(old, same).DebugString(),
            get(harness, "a", v1::SCENE_VIEW_FULL).scene().DebugString());
  const v1::Session other = fork("old", "b", "symmetric_rigid_body");
  EXPECT_NE(std::ranges::find(other.cleared(), "body"), other.cleared().end());
  EXPECT_EQ(merged(old, other).DebugString(),
            get(harness, "b", v1::SCENE_VIEW_FULL).scene().DebugString());
}

TEST(Views, AConversionIsShownAgainstTheScene) {
  test::Harness harness;
  v1::ConvertRequest request;
  *request.mutable_scene() = body_scene();
  request.set_to("symmetric_rigid_body");
  const auto filled_in = harness.convert(request);
  request.set_view(v1::SCENE_VIEW_FULL);
  const auto full = harness.convert(request);
  EXPECT_FALSE(filled_in.scene().has_step());
  EXPECT_TRUE(full.scene().has_step());
  EXPECT_EQ(merged(body_scene(), filled_in).DebugString(), full.scene().DebugString());
  EXPECT_GT(filled_in.margins_size(), 0);
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

TEST(Lists, EndAPageAtTheBytesOfAReply) {
  test::Harness harness;
  constexpr int count = 12;
  const v1::Scene scene = test::wire_scene({.method = "rk4", .dimension = 200});  // 640 KB
  for (int i = 0; i < count; ++i) harness.create(std::string(1, static_cast<char>('a' + i)), scene);
  v1::ListSessionsRequest request;
  request.mutable_view()->set_scene(v1::SCENE_VIEW_FULL);
  std::string ids;
  do {
    grpc::ClientContext context;
    v1::ListSessionsResponse response;
    ASSERT_TRUE(harness.stub->ListSessions(&context, request, &response).ok());
    EXPECT_LE(response.ByteSizeLong(), 2u << 20);
    EXPECT_EQ(response.sessions_size(), 3);
    for (const auto& session : response.sessions()) ids += session.session_id();
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  EXPECT_EQ(ids, "abcdefghijkl");
}

}  // namespace
}  // namespace stiefel
