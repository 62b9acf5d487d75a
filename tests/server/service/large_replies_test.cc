// A result is one message, whatever its size: states, scenes, checkpoints, conversions.
#include "tests/server/harness.h"

namespace stiefel {
namespace {

constexpr int columns = 200'000;  // a block has 3.2 MB

/// Geodesics on V(2, N): two blocks of 2 x N.
v1::Scene wide_scene() {
  v1::Scene scene;
  scene.set_system("stiefel");
  scene.mutable_method()->set_name("rk4");
  scene.set_step(0.01);
  for (int i = 0; i < columns; ++i) scene.add_inertia(1 + 0.25 * (i % 4));
  for (const char* name : {"Q", "S"}) {
    v1::Tensor& block = (*scene.mutable_initial_tensors())[name];
    block.set_data_type(v1::DATA_TYPE_FLOAT64);
    block.add_shape(2);
    block.add_shape(columns);
    RowMatrix values = RowMatrix::Zero(2, columns);
    const int at = *name == 'Q' ? 0 : 2;
    values(0, at) = values(1, at + 1) = 1;
    block.set_data(values.data(), static_cast<std::size_t>(values.size()) * sizeof(double));
  }
  return scene;
}

class LargeReplies : public testing::Test {
 protected:
  LargeReplies() { session_ = harness_.create("s", wide_scene()).session(); }

  /// Reads a stream of steps 1 to 5 with checkpoints.
  std::vector<v1::StreamResponse> streamed(test::Harness& harness, std::int64_t from) {
    v1::StreamRequest request;
    request.set_session_id("s");
    request.set_from(from);
    request.set_to(5);
    request.set_checkpoint_every(2);
    request.set_return_checkpoint(true);
    return harness.stream(request);
  }

  test::Harness harness_;
  v1::Session session_;
};

TEST_F(LargeReplies, AScene) {
  const v1::Scene given = wide_scene();
  for (const auto& [name, tensor] : given.initial_tensors()) {
    const auto& values = session_.scene().initial().at(name).values();
    ASSERT_EQ(values.size(), 2 * columns) << name;
    EXPECT_EQ(std::memcmp(values.data(), tensor.data().data(), tensor.data().size()), 0) << name;
  }
  EXPECT_EQ(session_.scene().inertia_size(), columns);
}

TEST_F(LargeReplies, AStateByEveryCall) {
  const Scene scene = Scene::resolve(server::from_proto(wide_scene())).value();
  const std::string expected = test::expected_bytes(scene, 2);
  EXPECT_EQ(test::bytes_of(harness_.step("s", 2).sample()), expected);

  grpc::ClientContext context;
  const auto drive = harness_.stub->Drive(&context);
  v1::DriveRequest ask;
  ask.set_session_id("s");
  ask.set_to(2);
  v1::DriveResponse reply;
  ASSERT_TRUE(drive->Write(ask) && drive->Read(&reply));
  EXPECT_EQ(test::bytes_of(reply.step().sample()), expected);
  drive->WritesDone();
  EXPECT_TRUE(drive->Finish().ok());

  const auto messages = streamed(harness_, 1);
  ASSERT_EQ(messages.size(), 5u);
  std::string second;
  for (const auto& field : messages[1].fields()) second += field.value().data();
  EXPECT_EQ(second, expected);
  EXPECT_TRUE(messages.back().has_run_status());
}

TEST_F(LargeReplies, ACheckpointComesWithItsSample) {
  const auto there = streamed(harness_, 1);
  for (const std::size_t i : {2, 4}) {
    ASSERT_TRUE(there[i].has_checkpoint());
    EXPECT_EQ(there[i].checkpoint().step(), there[i].steps(0));
    test::Harness other;
    other.create("s", wide_scene(), there[i].checkpoint().data());
    const auto last = streamed(other, 5);
    EXPECT_EQ(last.back().computed_steps(), 5 - there[i].checkpoint().step());
    for (int k = 0; k < 2; ++k)
      EXPECT_EQ(last[0].fields(k).value().data(), there[4].fields(k).value().data());
  }
}

TEST_F(LargeReplies, AConversion) {
  v1::ConvertRequest request;
  *request.mutable_scene() = wide_scene();
  request.set_to("stiefel_costate");
  request.set_return_scene(true);
  EXPECT_EQ(harness_.convert(request).scene().initial().at("P").values_size(), 2 * columns);
  request.set_to("velocity");
  EXPECT_EQ(harness_.convert(request).blocks(1).value().data().size(),
            2 * columns * sizeof(double));
}

/// 20 members with the 4096 x 4096 numbers of M.
TEST_F(LargeReplies, BeyondProtobufsLimitARequestIsRefused) {
  v1::Scene scene;
  scene.set_system("stiefel");
  scene.mutable_method()->set_name("rk4");
  scene.set_step(0.01);
  scene.set_members(20);
  for (int i = 0; i < 4096; ++i) scene.add_inertia(1);
  for (const char* name : {"Q", "S"}) {
    v1::Matrix& block = (*scene.mutable_initial())[name];
    block.set_rows(20);
    block.set_cols(4096);
    for (int i = 0; i < 20 * 4096; ++i) block.add_values(i % 4096 == (*name == 'Q' ? 0 : 1));
  }
  harness_.create("many", scene);
  v1::StepRequest request;
  request.set_session_id("many");
  request.add_fields("M");
  grpc::ClientContext context;
  v1::StepResponse response;
  const auto status = harness_.stub->Step(&context, request, &response);
  EXPECT_EQ(status.error_code(), grpc::INVALID_ARGUMENT);
  EXPECT_EQ(status.error_message(), "fields: 2684354560 bytes: a reply has at most 2146435072");
}

}  // namespace
}  // namespace stiefel
