#include <thread>

#include "tests/server/harness.h"

namespace stiefel {
namespace {

using namespace std::chrono_literals;

constexpr std::int64_t forever = 1'000'000'000'000;

TEST(Lifecycle, ListensWhereItSays) {
  server::Server server({.listen = {"127.0.0.1:0"}});
  ASSERT_EQ(server.addresses().size(), 1u);
  EXPECT_NE(server.addresses()[0], "127.0.0.1:0");
  const auto stub = v1::SimulationService::NewStub(
      grpc::CreateChannel(server.addresses()[0], grpc::InsecureChannelCredentials()));
  grpc::ClientContext context;
  v1::DescribeResponse response;
  EXPECT_TRUE(stub->Describe(&context, {}, &response).ok());
  EXPECT_THROW(server::Server({.listen = server.addresses()}), std::runtime_error)
      << "the address is taken";
}

TEST(Lifecycle, AStreamWithoutEndGetsALastCheckpoint) {
  test::Harness harness({.grace = 10ms});
  harness.create("s", test::wire_scene());
  v1::StreamRequest request;
  request.set_session_id("s");
  request.set_to(forever);
  request.set_return_checkpoint(true);
  grpc::ClientContext context;
  const auto stream = harness.stub->Stream(&context, request);
  v1::StreamResponse message;
  ASSERT_TRUE(stream->Read(&message));
  EXPECT_FALSE(message.has_run_status());
  std::jthread stopper([&] { harness.server.shutdown(); });
  while (stream->Read(&message)) continue;
  EXPECT_EQ(stream->Finish().error_code(), grpc::UNAVAILABLE);
  EXPECT_FALSE(message.has_run_status());
  EXPECT_TRUE(message.has_checkpoint());
  EXPECT_GT(message.checkpoint().step(), 0);
}

TEST(Lifecycle, ACancelledStepFreesItsWorker) {
  test::Harness harness({.threads = 1});
  harness.create("s", test::wire_scene());
  harness.create("t", test::wire_scene({.dimension = 5}));
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + 50ms);
  v1::StepRequest request;
  request.set_session_id("s");
  request.set_to(forever);
  v1::StepResponse response;
  EXPECT_EQ(harness.stub->Step(&context, request, &response).error_code(), grpc::DEADLINE_EXCEEDED);
  EXPECT_EQ(harness.step("t", 20'000).sample().step(), 20'000) << "on the only thread there is";
}

}  // namespace
}  // namespace stiefel
