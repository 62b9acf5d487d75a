// CreateSession with the id of a session and another scene that has the same numbers is refused.
#include "tests/server/harness.h"

namespace stiefel {
namespace {

/// An n x N matrix with this number on its diagonal.
v1::Matrix frame(int n, int N, double diagonal) {
  v1::Matrix frame;
  frame.set_rows(n);
  frame.set_cols(N);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < N; ++j) frame.add_values(i == j ? diagonal : 0);
  return frame;
}

grpc::StatusCode create_again(test::Harness& harness, const v1::Scene& scene) {
  v1::CreateSessionRequest request;
  request.set_session_id("s");
  *request.mutable_scene() = scene;
  grpc::ClientContext context;
  v1::CreateSessionResponse response;
  return harness.stub->CreateSession(&context, request, &response).error_code();
}

TEST(SameScene, OfOneMemberIsNotThatOfNone) {
  test::Harness harness;
  v1::Scene scene = test::wire_scene();
  harness.create("s", scene);
  EXPECT_EQ(create_again(harness, scene), grpc::OK);
  scene.set_members(1);
  EXPECT_EQ(create_again(harness, scene), grpc::ALREADY_EXISTS);
}

TEST(SameScene, OfFourRowsIsNotThatOfTwoMembersOfTwo) {
  test::Harness harness;
  v1::Scene scene;
  scene.set_system("stiefel");
  scene.mutable_method()->set_name("variational");
  scene.set_step(0.1);
  for (int k = 0; k < 6; ++k) scene.add_inertia(1 + k);
  (*scene.mutable_initial())["Q"] = frame(4, 6, 1);
  (*scene.mutable_initial())["S"] = frame(4, 6, 0);
  harness.create("s", scene);
  scene.set_members(2);
  EXPECT_EQ(create_again(harness, scene), grpc::ALREADY_EXISTS);
}

}  // namespace
}  // namespace stiefel
