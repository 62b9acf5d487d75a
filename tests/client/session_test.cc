// Sessions on a server: their states, how they end, and calls about them.
#include <gmock/gmock.h>

#include <algorithm>
#include <thread>

#include "server/server.h"
#include "stiefel/client/client.h"
#include "tests/client/error_of.h"
#include "tests/client/wire_scenes.h"

namespace stiefel::client {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;

class SessionTest : public testing::Test {
 protected:
  server::Server server_{{.listen = {"127.0.0.1:0"}, .threads = 1, .log_level = "off"}};
  Client client_ = Client::connect(server_.addresses().front());
};

TEST_F(SessionTest, ALargeStateIsOneMessage) {
  const auto session = client_.temporary(resting(512));
  EXPECT_EQ(session.description().scene().initial().at("Q").values_size(), 512 * 512);
  const std::vector<std::string> fields = {"Q", "M", "Omega"};  // 6 MiB
  EXPECT_EQ(Sample(session.step(0, fields).sample()).field("Q"),
            Eigen::MatrixXd::Identity(512, 512));
  int samples = 0;
  for (const Sample& sample : session.stream({.to = 0, .fields = fields})) {
    EXPECT_EQ(sample.field("Q"), Eigen::MatrixXd::Identity(512, 512));
    EXPECT_EQ(sample.field("M").squaredNorm(), 0);
    EXPECT_EQ(sample.field("Omega").squaredNorm(), 0);
    ++samples;
  }
  EXPECT_EQ(samples, 1);
}

TEST_F(SessionTest, ADriveGoesBackAndForthAndOutlivesAWrongRequest) {
  const auto session = client_.create(tumbling());
  auto drive = session.drive();
  for (const std::int64_t to : {30, 10, 20}) EXPECT_EQ(drive.step(to).sample().step(), to);

  const Error error = error_of([&] { drive.step(-1); });
  EXPECT_EQ(error.code(), grpc::StatusCode::INVALID_ARGUMENT);
  ASSERT_EQ(error.violations().size(), 1u);
  EXPECT_EQ(error.violations()[0].field, "to");

  EXPECT_THAT(Sample(drive.step(40, {"Q"}).sample()).fields(), ElementsAre("Q"));
  EXPECT_THAT(Sample(drive.step(41).sample()).fields(), ElementsAre("Q")) << "still in force";
  server_.shutdown();
  EXPECT_EQ(error_of([&] { drive.step(42); }).code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(error_of([&] { drive.step(42); }).code(), grpc::StatusCode::FAILED_PRECONDITION);
}

TEST_F(SessionTest, OnlyATemporarySessionGoesWithItsHandles) {
  std::string kept, gone;
  {
    kept = client_.create(tumbling(), "kept").id();
    const auto session = client_.temporary(tumbling());
    gone = session.id();
    const Session first = session, second = client_.get(gone);
  }
  ASSERT_EQ(client_.list().size(), 1u);
  EXPECT_EQ(client_.list()[0].session_id(), kept);
  const Error error = error_of([&] { client_.get(gone); });
  EXPECT_EQ(error.code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(error.reason(), "SESSION_DELETED");
  EXPECT_EQ(error.metadata().at("session_id"), gone);
  EXPECT_EQ(client_.get(kept).step(1).sample().step(), 1);
  client_.remove(kept);
  client_.remove(kept);
  EXPECT_TRUE(client_.list().empty());
}

TEST_F(SessionTest, SamplesKeepATemporarySession) {
  {
    auto samples = client_.temporary(tumbling()).stream({.to = std::int64_t{1} << 50});
    ASSERT_NE(samples.next_batch(), nullptr);
    EXPECT_EQ(client_.list().size(), 1u);
  }
  EXPECT_TRUE(client_.list().empty());
}

TEST_F(SessionTest, HasTheResolvedScene) {
  const auto session = client_.create(tumbling());
  for (int i = 0; i < 100; ++i) client_.create(tumbling());
  EXPECT_EQ(client_.list().size(), 101u) << "which is more than a page";
  const v1::Scene& scene = session.description().scene();
  EXPECT_EQ(scene.method().order(), 2u);
  EXPECT_EQ(scene.body().moments_size(), 3);
  EXPECT_EQ(client_.get(session.id()).description().scene().SerializeAsString(),
            scene.SerializeAsString());

  v1::ForkSessionRequest request;
  request.set_from_step(7);
  request.set_step(0.005);
  const auto fork = session.fork(request);
  EXPECT_EQ(fork.description().scene().step(), 0.005);
  EXPECT_EQ(Sample(fork.step(0, {"M"}).sample()).field("M"),
            Sample(session.step(7, {"M"}).sample()).field("M"));
}

TEST_F(SessionTest, MakesEveryCall) {
  const auto session = client_.create(tumbling());
  v1::DiagnoseRequest diagnose;
  diagnose.set_to(10);
  diagnose.add_invariants("energy");
  EXPECT_EQ(session.call(&Stub::Diagnose, diagnose).invariants_size(), 1);

  v1::SummarizeRequest summarize;
  summarize.set_to(10);
  summarize.add_quantities()->set_name("M");
  summarize.mutable_quantities(0)->add_statistics(v1::STATISTIC_LAST);
  int statistics = 0;
  for (const auto& reply : session.call(&Stub::Summarize, summarize))
    for (const auto& statistic : reply.statistics())
      if (statistic.value().data_type() == v1::DATA_TYPE_FLOAT64) {
        EXPECT_EQ(matrix(statistic.value()), Sample(session.step(10, {"M"}).sample()).field("M"));
        ++statistics;
      }
  EXPECT_EQ(statistics, 1);

  v1::ConvertRequest convert;
  *convert.mutable_scene() = tumbling();
  convert.set_to("symmetric_rigid_body");
  convert.set_return_scene(true);
  EXPECT_EQ(client_.call(&Stub::Convert, convert).scene().system(), "symmetric_rigid_body");
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
    const auto end = matrix(geodesics[i].trajectory().value(), 4);
    EXPECT_NEAR(end(0, static_cast<int>(i) + 1), 1, 1e-11) << "it ends on its own axis";
  }
}

TEST_F(SessionTest, AStreamCanBeDroppedOrCancelled) {
  const auto session = client_.create(tumbling());
  const Range endless{.to = std::int64_t{1} << 50};
  {
    auto samples = session.stream(endless);
    EXPECT_EQ(samples.begin()->step(), 0);
  }
  auto samples = session.stream(endless);
  ASSERT_NE(samples.next_batch(), nullptr);
  const std::jthread other([&] { samples.cancel(); });
  const Error error = error_of([&] {
    while (samples.next_batch()) {
    }
  });
  EXPECT_EQ(error.code(), grpc::StatusCode::CANCELLED);
  EXPECT_EQ(session.step(5).sample().step(), 5);
}

TEST_F(SessionTest, AStopRequestCancelsWhatRunsAndWhatIsYetToBegin) {
  std::stop_source source;
  const Client client = Client::connect(server_.addresses()[0], {.stop = source.get_token()});
  const auto session = client.temporary(tumbling());
  auto samples = session.stream({.to = std::int64_t{1} << 40});
  ASSERT_NE(samples.next_batch(), nullptr);
  const std::jthread stopper([&] { source.request_stop(); });
  EXPECT_EQ(error_of([&] { session.step(std::int64_t{1} << 40); }).code(),
            grpc::StatusCode::CANCELLED);
  const Error error = error_of([&] {
    while (samples.next_batch()) {
    }
  });
  EXPECT_EQ(error.code(), grpc::StatusCode::CANCELLED);
}

TEST_F(SessionTest, ATimeoutEndsACallButNotADrive) {
  const Client client = Client::connect(server_.addresses()[0], {.timeout = 300ms});
  const auto session = client_.create(tumbling());
  const auto late = client.get(session.id());
  auto drive = late.drive();
  EXPECT_EQ(error_of([&] { late.step(std::int64_t{1} << 40); }).code(),
            grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_EQ(drive.step(1).sample().step(), 1);
}

}  // namespace
}  // namespace stiefel::client
