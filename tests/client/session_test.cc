#include <gmock/gmock.h>
#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <map>
#include <regex>

#include "client/cpp/uuid.h"
#include "server/server.h"
#include "stiefel/client/client.h"
#include "tests/client/error_of.h"
#include "tests/client/wire_scenes.h"

namespace stiefel::client {
namespace {

using testing::ElementsAre;

class SessionTest : public testing::Test {
 protected:
  server::Server server_{{.listen = {"127.0.0.1:0"}, .threads = 1, .log_level = "off"}};
  Client client_{server_.in_process_channel()};
};

std::string bytes(const v1::StepResponse& reply) {
  std::string all;
  for (const auto& field : reply.sample().fields()) all += field.value().data();
  return all;
}

TEST_F(SessionTest, TheStateAtAStepHasTheSameBitsHoweverItIsAskedFor) {
  const auto session = client_.create(tumbling());
  const std::string expected = bytes(session.step(300));
  ASSERT_EQ(expected.size(), 7 * sizeof(double)) << "quaternion and angular velocity";

  auto drive = session.drive();
  EXPECT_EQ(bytes(drive.step(300)), expected);

  auto stream = session.stream({.from = 0, .to = 300, .every = 7});
  std::string last;
  for (const SampleView sample : stream) {
    last.clear();
    for (int i = 0; i < sample.field_count(); ++i) {
      const auto values = sample.field(i).values;
      last.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
    }
  }
  EXPECT_EQ(last, expected);

  const auto checkpoint = session.checkpoint(200).checkpoint();
  const auto other = client_.create(tumbling(), "", checkpoint);
  const auto reply = other.step(300);
  EXPECT_EQ(bytes(reply), expected);
  EXPECT_EQ(reply.computed_steps(), 100);
}

TEST_F(SessionTest, StreamsTheGridAndTheLastSample) {
  const auto session = client_.create(tumbling());
  auto stream = session.stream({.from = 2, .to = 11, .every = 4, .fields = {"quaternion"}});
  std::vector<std::int64_t> steps;
  for (const SampleView sample : stream) {
    steps.push_back(sample.step());
    EXPECT_DOUBLE_EQ(sample.time(), 0.01 * static_cast<double>(sample.step()));
    EXPECT_EQ(sample.field_count(), 1);
    const auto q = sample.field("quaternion");
    EXPECT_EQ(q.rows, 1u);
    EXPECT_EQ(q.cols, 4u);
    EXPECT_NEAR(q.values[0] * q.values[0] + q.values[1] * q.values[1] + q.values[2] * q.values[2] +
                    q.values[3] * q.values[3],
                1, 1e-14);
    EXPECT_THROW(sample.field("Q"), std::out_of_range);
  }
  EXPECT_THAT(steps, ElementsAre(2, 6, 10, 11));
  ASSERT_TRUE(stream.run_status());
  EXPECT_EQ(stream.run_status()->outcome(), v1::OUTCOME_REACHED);
}

TEST_F(SessionTest, AStreamCanBeDroppedInTheMiddle) {
  const auto session = client_.create(tumbling());
  {
    auto stream = session.stream({.to = std::int64_t{1} << 50});
    EXPECT_EQ((*stream.begin()).step(), 0);
  }
  EXPECT_EQ(session.step(5).sample().step(), 5);
}

TEST_F(SessionTest, ADriveGoesBackAndForthAndOutlivesABadRequest) {
  const auto session = client_.create(tumbling());
  auto drive = session.drive();
  for (const std::int64_t to : {30, 10, 20}) EXPECT_EQ(drive.step(to).sample().step(), to);

  const Error error = error_of([&] { drive.step(-1); });
  EXPECT_EQ(error.code(), grpc::StatusCode::INVALID_ARGUMENT);
  ASSERT_EQ(error.violations().size(), 1u);
  EXPECT_EQ(error.violations()[0].field, "to");

  const auto sample = drive.step(40, {"quaternion"}).sample();
  EXPECT_EQ(field(sample, "quaternion").values.size(), 4u);
  EXPECT_THROW(field(sample, "Q"), std::out_of_range);
}

TEST_F(SessionTest, SessionsGoWithTheirHandleUnlessKept) {
  std::string id;
  {
    const auto session = client_.create(tumbling());
    id = session.id();
    EXPECT_EQ(client_.list().size(), 1u);
    const auto moved = client_.attach(id);  // does not own it
  }
  EXPECT_TRUE(client_.list().empty());
  const Error gone = error_of([&] { client_.attach(id); });
  EXPECT_EQ(gone.code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(gone.reason(), "SESSION_DELETED");
  EXPECT_EQ(gone.metadata().at("session_id"), id);

  {
    auto session = client_.create(tumbling(), "kept");
    session.keep();
  }
  EXPECT_EQ(client_.attach("kept").step(1).sample().step(), 1);
  client_.remove("kept");
  client_.remove("kept");
  EXPECT_TRUE(client_.list().empty());
}

TEST_F(SessionTest, AMovedSessionIsDeletedOnce) {
  auto session = std::make_unique<Session>(client_.create(tumbling(), "moved"));
  const Session heir = std::move(*session);
  session.reset();
  EXPECT_EQ(heir.step(1).sample().step(), 1);
}

TEST_F(SessionTest, ListsMoreThanAPage) {
  std::vector<Session> sessions;
  for (int i = 0; i < 101; ++i) sessions.push_back(client_.create(tumbling()));
  EXPECT_EQ(client_.list().size(), 101u);
}

/// The blocks of a scene, by name, as the matrices that they are.
std::map<std::string, std::string> blocks(const v1::Scene& scene) {
  std::map<std::string, std::string> all;
  for (const auto& [name, block] : scene.initial()) all[name] = block.SerializeAsString();
  return all;
}

TEST_F(SessionTest, UpToN512EverythingWorksWithTheSizesOfAStockClient) {
  const v1::Scene scene = resting(512);
  const std::vector<std::string> fields = {"Q", "M", "Omega"};
  for (const Client& client : {client_, Client::connect(server_.addresses()[0])}) {
    const auto session = client.create(scene);
    EXPECT_EQ(blocks(session.scene()), blocks(scene));
    const auto sample = session.step(1, fields).sample();
    auto drive = session.drive();
    const auto driven = drive.step(1, fields).sample();
    auto stream = session.stream({.from = 1, .to = 1, .fields = fields});
    const auto streamed = *stream.begin();
    for (const auto& name : fields) {
      const auto values = field(sample, name).values;
      ASSERT_EQ(values.size(), 512u * 512u);
      EXPECT_TRUE(std::ranges::equal(values, field(driven, name).values));
      EXPECT_TRUE(std::ranges::equal(values, streamed.field(name).values));
    }

    const auto checkpoint = session.checkpoint(1).checkpoint();
    EXPECT_GT(checkpoint.size(), std::size_t{4} << 20);
    EXPECT_EQ(client.create(scene, "", checkpoint).step(1).computed_steps(), 0);

    const auto seen = client.attach(session.id());
    EXPECT_EQ(blocks(seen.scene()), blocks(scene)) << "of a client that did not send them";
    v1::ForkSessionRequest request;
    request.set_from_step(1);
    const auto fork = session.fork(request);
    EXPECT_EQ(fork.scene().initial().at("Q").values_size(), 512 * 512);
  }
}

TEST_F(SessionTest, HoldsTheResolvedScene) {
  const auto session = client_.create(tumbling());
  EXPECT_EQ(session.scene().method().order(), 2u);
  EXPECT_EQ(session.scene().method().arithmetic(), "compensated");
  EXPECT_EQ(session.scene().body().moments_size(), 3);
  EXPECT_EQ(session.choice(), nullptr);
  const auto seen = client_.attach(session.id());
  EXPECT_TRUE(google::protobuf::util::MessageDifferencer::Equals(seen.scene(), session.scene()));
  const auto again = client_.create(session.scene());
  EXPECT_EQ(bytes(again.step(50)), bytes(session.step(50)));
}

TEST_F(SessionTest, TellsTheMethodThatWasChosen) {
  v1::Scene scene = tumbling();
  scene.clear_method();
  scene.set_tolerance(1e-6);
  scene.set_horizon(1);
  const auto session = client_.create(scene);
  ASSERT_NE(session.choice(), nullptr);
  EXPECT_EQ(session.choice()->tolerance(), 1e-6);
  EXPECT_FALSE(session.choice()->reason().empty());
  EXPECT_EQ(session.scene().method().name(), session.choice()->method().name());
  EXPECT_FALSE(session.scene().has_tolerance());
}

TEST_F(SessionTest, AFloatSceneHasFloats) {
  v1::Scene scene = tumbling();
  scene.mutable_method()->set_scalar("float");
  const auto session = client_.create(scene);
  const auto sample = session.step(10, {"Q"}).sample();
  const auto Q = field(sample, "Q");
  EXPECT_EQ(Q.floats.size(), 9u);
  EXPECT_TRUE(Q.values.empty());
  auto stream = session.stream({.from = 10, .to = 10, .fields = {"Q"}});
  const auto streamed = (*stream.begin()).field("Q");
  EXPECT_TRUE(std::ranges::equal(Q.floats, streamed.floats));
  EXPECT_EQ(streamed[8], static_cast<double>(Q.floats[8]));
}

TEST_F(SessionTest, ConvertsToAWholeScene) {
  v1::ConvertRequest request;
  *request.mutable_scene() = tumbling();
  request.set_to("symmetric_rigid_body");
  const auto converted = client_.convert(request);
  EXPECT_EQ(converted.scene().system(), "symmetric_rigid_body");
  EXPECT_EQ(converted.scene().step(), 0.01);
  const auto session = client_.create(converted.scene());
  EXPECT_EQ(session.step(1, {"P"}).sample().step(), 1);
  request.set_to("velocity");
  const auto velocity = client_.convert(request);
  EXPECT_FALSE(velocity.has_scene());
  EXPECT_EQ(velocity.blocks_size(), 2);
}

TEST_F(SessionTest, JoinsManyPairsOfFrames) {
  v1::ConnectRequest request;
  for (const double lambda : {1, 2, 3}) request.add_inertia(lambda);
  request.set_time(1);
  request.set_samples(4);
  for (int axis = 1; axis <= 2; ++axis) {
    auto& pair = *request.add_pairs();
    for (auto* frame : {pair.mutable_q_0(), pair.mutable_q_t()}) {
      frame->set_rows(1);
      frame->set_cols(3);
      for (int i = 0; i < 3; ++i)
        frame->add_values(frame == pair.mutable_q_0() ? i == 0 : i == axis);
    }
  }
  const auto geodesics = client_.geodesics(request);
  ASSERT_EQ(geodesics.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(geodesics[i].pair(), i);
    EXPECT_LT(geodesics[i].residual(), 1e-11);
    const auto Q = values(geodesics[i].trajectory().value());
    ASSERT_EQ(Q.size(), 15u);
    EXPECT_NEAR(Q[12 + i + 1], 1, 1e-11) << "it ends on its own axis";
  }
}

TEST(Uuid, IsAVersion4Uuid) {
  const std::regex form("[0-9a-f]{8}-[0-9a-f]{4}-4[0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}");
  EXPECT_TRUE(std::regex_match(make_uuid(), form));
  EXPECT_NE(make_uuid(), make_uuid());
}

}  // namespace
}  // namespace stiefel::client
