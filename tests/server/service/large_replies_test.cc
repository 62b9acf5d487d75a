// States, scenes and checkpoints of any size reach a client that accepts 4 MiB a message.
#include <map>

#include "tests/server/harness.h"

namespace stiefel {
namespace {

constexpr std::size_t stock_message = std::size_t{4} << 20;

/// Geodesics on V(2, N): two blocks of 2 x N.
v1::Scene wide_scene(int N) {
  v1::Scene scene;
  scene.set_system("stiefel");
  scene.mutable_method()->set_name("rk4");
  scene.set_step(0.01);
  for (int i = 0; i < N; ++i) scene.add_inertia(1 + 0.25 * (i % 4));
  for (const char* name : {"Q", "S"}) {
    v1::Tensor& block = (*scene.mutable_initial_tensors())[name];
    block.set_data_type(v1::DATA_TYPE_FLOAT64);
    block.add_shape(2);
    block.add_shape(static_cast<std::uint64_t>(N));
    RowMatrix values = RowMatrix::Zero(2, N);
    const int at = *name == 'Q' ? 0 : 2;
    values(0, at) = values(1, at + 1) = 1;
    block.set_data(values.data(), static_cast<std::size_t>(values.size()) * sizeof(double));
  }
  return scene;
}

/// Arrays of a stream's messages, put together from their parts.
class Arrays {
 public:
  void add(const v1::Field& field) {
    if (field.whole_shape_size() == 0) {
      EXPECT_TRUE(data_.emplace(field.name(), field.value().data()).second) << field.name();
      return;
    }
    std::string& data = data_[field.name()];
    EXPECT_EQ(field.offset() * sizeof(double), data.size()) << field.name();
    data += field.value().data();
  }
  const std::string& operator[](const std::string& name) { return data_[name]; }
  std::string all() const {
    std::string out;
    for (const auto& [name, data] : data_) out += data;
    return out;
  }

 private:
  std::map<std::string, std::string> data_;
};

class LargeReplies : public testing::Test {
 protected:
  static constexpr int N = 200'000;  // a block has 3.2 MB

  v1::StreamRequest range(std::int64_t from, std::int64_t to) {
    v1::StreamRequest request;
    request.set_session_id("s");
    request.set_from(from);
    request.set_to(to);
    return request;
  }
  v1::Session create(v1::SceneView view) {
    v1::CreateSessionRequest request;
    request.set_session_id("s");
    *request.mutable_scene() = wide_scene(N);
    request.mutable_view()->set_scene(view);
    grpc::ClientContext context;
    v1::CreateSessionResponse response;
    const auto status = harness_.stub->CreateSession(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    EXPECT_LT(response.ByteSizeLong(), stock_message);
    return response.session();
  }

  test::Harness harness_;
};

TEST_F(LargeReplies, AStateTravelsInParts) {
  create(v1::SCENE_VIEW_UNSPECIFIED);
  const auto messages = harness_.stream(range(1, 2));
  const Scene scene = Scene::resolve(server::from_proto(wide_scene(N))).value();
  std::map<std::int64_t, Arrays> samples;
  std::int64_t open = -1;
  for (const auto& message : messages) {
    EXPECT_LE(message.ByteSizeLong(), stock_message / 2);
    ASSERT_EQ(message.steps_size(), 1);
    ASSERT_EQ(message.times(0), scene.time(message.steps(0)));
    if (open >= 0) {
      EXPECT_EQ(message.steps(0), open) << "the sample goes on";
    }
    open = message.sample_continues() ? message.steps(0) : -1;
    for (const auto& field : message.fields()) samples[message.steps(0)].add(field);
  }
  EXPECT_EQ(open, -1);
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_TRUE(messages.back().has_run_status());
  EXPECT_GT(messages.front().work(), 0);
  for (std::int64_t step : {1, 2})
    EXPECT_EQ(samples[step].all(), test::expected_bytes(scene, step)) << step;
}

TEST_F(LargeReplies, AStepThatIsTooLargeSaysSo) {
  create(v1::SCENE_VIEW_UNSPECIFIED);
  const auto refused = [&](const grpc::Status& status) {
    EXPECT_EQ(status.error_code(), grpc::INVALID_ARGUMENT);
    EXPECT_NE(status.error_message().find("Stream"), std::string::npos) << status.error_message();
    v1::Status details;
    EXPECT_TRUE(details.ParseFromString(status.error_details()));
    v1::ErrorInfo info;
    EXPECT_EQ(details.details_size(), 2);
    EXPECT_TRUE(info.ParseFromString(details.details(details.details_size() - 1).value()));
    EXPECT_EQ(info.reason(), "REPLY_TOO_LARGE");
    EXPECT_EQ(info.metadata().at("max_bytes"), "2097152");
    return info.metadata().at("bytes");
  };
  v1::StepRequest request;
  request.set_session_id("s");
  grpc::ClientContext context;
  v1::StepResponse response;
  EXPECT_EQ(refused(harness_.stub->Step(&context, request, &response)),
            std::to_string(2 * 2 * N * sizeof(double)));
  grpc::ClientContext drive_context;
  const auto drive = harness_.stub->Drive(&drive_context);
  v1::DriveRequest ask;
  ask.set_session_id("s");
  v1::DriveResponse reply;
  ASSERT_TRUE(drive->Write(ask) && drive->Read(&reply));
  refused({static_cast<grpc::StatusCode>(reply.error().code()), reply.error().message(),
           reply.error().SerializeAsString()});
  drive->WritesDone();
  EXPECT_TRUE(drive->Finish().ok());
}

TEST_F(LargeReplies, AFullViewNamesWhatItLeavesOutAndStreamSendsIt) {
  const v1::Session session = create(v1::SCENE_VIEW_FULL);
  EXPECT_EQ(session.left_out_size(), 2);
  EXPECT_EQ(session.scene().inertia_size(), N) << "what fits is there";
  EXPECT_EQ(session.scene().initial().size(), 0u);
  v1::StreamRequest request = range(0, 0);
  request.set_scene_arrays(true);
  Arrays arrays;
  for (const auto& message : harness_.stream(request)) {
    EXPECT_LE(message.ByteSizeLong(), stock_message / 2);
    EXPECT_TRUE(message.scene_arrays().empty() || message.fields().empty());
    for (const auto& array : message.scene_arrays()) arrays.add(array);
  }
  const v1::Scene given = wide_scene(N);
  for (const std::string& path : session.left_out())
    EXPECT_EQ(arrays[path], given.initial_tensors().at(path.substr(8)).data()) << path;
  EXPECT_EQ(arrays["inertia"].size(), N * sizeof(double));
}

TEST_F(LargeReplies, CheckpointsTravelInRanges) {
  create(v1::SCENE_VIEW_UNSPECIFIED);
  v1::StreamRequest request = range(0, 5);
  request.set_checkpoint_every(2);
  request.set_return_checkpoint(true);
  const auto messages = harness_.stream(request);
  std::map<std::int64_t, std::string> checkpoints;
  std::int64_t sampled = -1;
  for (const auto& message : messages) {
    EXPECT_LE(message.ByteSizeLong(), stock_message / 2);
    if (message.steps_size() > 0) sampled = message.steps(message.steps_size() - 1);
    if (!message.has_checkpoint()) continue;
    EXPECT_EQ(message.checkpoint().step(), sampled) << "after its sample";
    std::string& bytes = checkpoints[message.checkpoint().step()];
    EXPECT_EQ(message.checkpoint().offset(), bytes.size());
    bytes += message.checkpoint().data();
    EXPECT_LE(bytes.size(), message.checkpoint().size());
  }
  ASSERT_EQ(checkpoints.size(), 3u);
  for (const std::int64_t step : {2, 4, 5}) {
    test::Harness other;
    other.create("s", wide_scene(N), checkpoints.at(step));
    v1::StreamRequest last_step = range(5, 5);
    const auto there = other.stream(last_step);
    EXPECT_EQ(there.back().computed_steps(), 5 - step);
    Arrays arrays, expected;
    for (const auto& message : there)
      for (const auto& field : message.fields()) arrays.add(field);
    for (const auto& message : harness_.stream(last_step))
      for (const auto& field : message.fields()) expected.add(field);
    EXPECT_EQ(arrays.all(), expected.all());
  }
}

TEST(LargeConversions, TravelInParts) {
  test::Harness harness;
  v1::ConvertRequest request;
  *request.mutable_scene() = wide_scene(200'000);
  for (const char* to : {"stiefel_costate", "velocity"}) {
    request.set_to(to);
    const auto messages = harness.convert(request);
    EXPECT_GT(messages.size(), 2u) << to;
    Arrays arrays;
    for (const auto& message : messages) {
      EXPECT_LE(message.ByteSizeLong(), stock_message) << to;
      for (const auto& array : message.scene_arrays()) arrays.add(array);
      for (const auto& block : message.blocks()) arrays.add(block);
    }
    // Q is the caller's; what the server made of S is new.
    const char* made = request.to() == "velocity" ? "Qdot" : "initial.P";
    EXPECT_EQ(arrays[made].size(), 2u * 200'000 * sizeof(double)) << to;
  }
}

}  // namespace
}  // namespace stiefel
