// The state at step 10 000 has the same bytes on every path to it.
#include <latch>
#include <thread>

#include "tests/server/harness.h"

namespace stiefel {
namespace {

constexpr std::int64_t last = 10'000;

class Bits : public testing::TestWithParam<test::Case> {
 protected:
  void SetUp() override { harness_.create("s", test::wire_scene(GetParam())); }

  test::Harness harness_;
  const std::string expected_ = test::expected_bytes(test::scene(GetParam()), last);

  /// States computed for so many steps: a closed form computes one.
  static std::int64_t computed(std::int64_t steps) {
    return GetParam().method == "exact" ? 1 : steps;
  }
};
INSTANTIATE_TEST_SUITE_P(Service, Bits, testing::ValuesIn(test::cases()),
                         [](const auto& which) { return which.param.name(); });

TEST_P(Bits, OneStepPastItAndBack) {
  const auto reply = harness_.step("s", last);
  EXPECT_EQ(test::bytes_of(reply.sample()), expected_);
  EXPECT_EQ(reply.run_status().outcome(), v1::OUTCOME_REACHED);
  EXPECT_EQ(reply.computed_steps(), computed(last));
  EXPECT_EQ(reply.sample().time(), last * 0.01);
  harness_.step("s", last + 777);
  EXPECT_EQ(test::bytes_of(harness_.step("s", last).sample()), expected_);
  harness_.step("s", 3);
  EXPECT_EQ(test::bytes_of(harness_.step("s", last).sample()), expected_);
}

TEST_P(Bits, Drive) {
  grpc::ClientContext context;
  const auto drive = harness_.stub->Drive(&context);
  v1::DriveRequest request;
  request.set_session_id("s");
  v1::DriveResponse response;
  for (std::int64_t step = 1; step <= last; ++step) {
    request.set_to(step);
    ASSERT_TRUE(drive->Write(request) && drive->Read(&response));
    ASSERT_EQ(response.step().sample().step(), step);
    ASSERT_EQ(response.step().computed_steps(), 1);
  }
  EXPECT_EQ(test::bytes_of(response.step().sample()), expected_);
  drive->WritesDone();
  EXPECT_TRUE(drive->Finish().ok());
}

TEST_P(Bits, Stream) {
  v1::StreamRequest request;
  request.set_session_id("s");
  request.set_to(last);
  grpc::ClientContext context;
  const auto stream = harness_.stub->Stream(&context, request);
  v1::StreamResponse message;
  std::int64_t next = 0;
  std::string bytes;
  while (stream->Read(&message)) {
    ASSERT_LE(message.ByteSizeLong(), 256u << 10);
    bytes.clear();
    for (const auto& field : message.fields()) {
      const auto& shape = field.value().shape();
      ASSERT_EQ(shape.size(), 3);
      ASSERT_EQ(shape[0], static_cast<std::uint64_t>(message.steps_size()));
      const std::size_t size = sizeof(double) * shape[1] * shape[2];
      ASSERT_EQ(field.value().data().size(), size * shape[0]);
      bytes += field.value().data().substr(size * (shape[0] - 1));
    }
    for (const std::int64_t step : message.steps()) ASSERT_EQ(step, next++);
  }
  EXPECT_TRUE(stream->Finish().ok());
  EXPECT_EQ(next, last + 1);
  EXPECT_EQ(bytes, expected_);
  EXPECT_EQ(message.run_status().outcome(), v1::OUTCOME_REACHED);
  EXPECT_EQ(message.computed_steps(), last);
}

TEST_P(Bits, EightClientsAtOnce) {
  std::latch start(8);
  std::vector<std::jthread> clients;
  for (int i = 0; i < 8; ++i) {
    clients.emplace_back([&, i] {
      start.arrive_and_wait();
      harness_.step("s", i * 1234);
      EXPECT_EQ(test::bytes_of(harness_.step("s", last).sample()), expected_);
    });
  }
}

TEST_P(Bits, AnotherServer) {
  const auto halfway = harness_.step("s", 6'000, true);
  const auto session = harness_.create("s", test::wire_scene(GetParam())).session();
  test::Harness from_scene;
  from_scene.create("t", session.scene());
  EXPECT_EQ(test::bytes_of(from_scene.step("t", last).sample()), expected_);

  test::Harness from_checkpoint;
  from_checkpoint.create("t", session.scene(), halfway.checkpoint());
  const auto reply = from_checkpoint.step("t", last);
  EXPECT_EQ(test::bytes_of(reply.sample()), expected_);
  EXPECT_EQ(reply.computed_steps(), computed(last - 6'000));
}

TEST(OneByOne, TenThousandSteps) {
  test::Harness harness;
  harness.create("s", test::wire_scene());
  v1::StepResponse reply;
  for (std::int64_t step = 1; step <= last; ++step) reply = harness.step("s", step);
  EXPECT_EQ(test::bytes_of(reply.sample()), test::expected_bytes(test::scene(), last));
}

}  // namespace
}  // namespace stiefel
