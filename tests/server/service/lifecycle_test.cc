#include <thread>

#include "grpc/health/v1/health.grpc.pb.h"
#include "tests/server/harness.h"

namespace stiefel {
namespace {

using namespace std::chrono_literals;
using grpc::health::v1::HealthCheckResponse;

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

TEST(Lifecycle, HealthTellsOfTheShutdown) {
  // Over a socket: the in-process transport closes before a watcher hears of it.
  server::Server server({.listen = {"127.0.0.1:0"}});
  const auto health = grpc::health::v1::Health::NewStub(
      grpc::CreateChannel(server.addresses()[0], grpc::InsecureChannelCredentials()));
  for (const char* service : {"", "stiefel.v1.SimulationService"}) {
    grpc::ClientContext context;
    grpc::health::v1::HealthCheckRequest request;
    request.set_service(service);
    HealthCheckResponse response;
    ASSERT_TRUE(health->Check(&context, request, &response).ok());
    EXPECT_EQ(response.status(), HealthCheckResponse::SERVING);
  }
  grpc::ClientContext context;
  const auto watch = health->Watch(&context, {});
  HealthCheckResponse response;
  ASSERT_TRUE(watch->Read(&response));
  EXPECT_EQ(response.status(), HealthCheckResponse::SERVING);
  std::jthread stopper([&] { server.shutdown(); });
  ASSERT_TRUE(watch->Read(&response));
  EXPECT_EQ(response.status(), HealthCheckResponse::NOT_SERVING);
}

TEST(Lifecycle, AStepWithoutEndStopsWithTheServer) {
  test::Harness harness({.grace = 10ms});
  harness.create("s", test::wire_scene());
  v1::StepResponse reply;
  std::jthread caller([&] { reply = harness.step("s", forever); });
  while (true) {
    grpc::ClientContext context;
    v1::GetSessionRequest request;
    request.set_session_id("s");
    v1::GetSessionResponse response;
    ASSERT_TRUE(harness.stub->GetSession(&context, request, &response).ok());
    if (response.session().cached_steps_size() > 1) break;  // it runs
  }
  harness.server.shutdown();
  caller.join();
  EXPECT_EQ(reply.run_status().outcome(), v1::OUTCOME_CANCELLED);
  EXPECT_GT(reply.sample().step(), 0);
  EXPECT_LT(reply.sample().step(), forever);
  EXPECT_EQ(reply.sample().step(), reply.computed_steps());
}

TEST(Lifecycle, AStreamWithoutEndGetsALastMessage) {
  test::Harness harness({.grace = 10ms});
  harness.create("s", test::wire_scene());
  v1::StreamRequest request;
  request.set_session_id("s");
  request.set_to(forever);
  grpc::ClientContext context;
  const auto stream = harness.stub->Stream(&context, request);
  v1::StreamResponse message;
  ASSERT_TRUE(stream->Read(&message));
  EXPECT_FALSE(message.has_run_status());
  std::jthread stopper([&] { harness.server.shutdown(); });
  while (stream->Read(&message)) continue;
  EXPECT_TRUE(stream->Finish().ok());
  EXPECT_EQ(message.run_status().outcome(), v1::OUTCOME_CANCELLED);
}

TEST(Lifecycle, NewWorkIsRefused) {
  test::Harness harness({.grace = 2s});
  harness.create("s", test::wire_scene());
  grpc::ClientContext running_context;
  v1::StreamRequest endless;
  endless.set_session_id("s");
  endless.set_to(forever);
  const auto running = harness.stub->Stream(&running_context, endless);
  v1::StreamResponse message;
  ASSERT_TRUE(running->Read(&message));
  std::jthread stopper([&] { harness.server.shutdown(); });
  grpc::Status status;
  while (status.ok()) {
    grpc::ClientContext context;
    v1::StepRequest request;
    request.set_session_id("s");
    v1::StepResponse response;
    status = harness.stub->Step(&context, request, &response);
  }
  EXPECT_EQ(status.error_code(), grpc::UNAVAILABLE);
  running_context.TryCancel();
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

TEST(Lifecycle, EndlessStepsDoNotHoldUpAnother) {
  test::Harness harness({.threads = 1});
  harness.create("s", test::wire_scene());
  grpc::ClientContext context;
  grpc::CompletionQueue queue;
  v1::StepRequest request;
  request.set_session_id("s");
  request.set_to(forever);
  const auto endless = harness.stub->AsyncStep(&context, request, &queue);
  v1::StepResponse never;
  grpc::Status status;
  endless->Finish(&never, &status, nullptr);
  EXPECT_EQ(harness.step("s", 50'000).sample().step(), 50'000)
      << "the same session, the same thread";
  context.TryCancel();
  void* tag;
  bool ok;
  EXPECT_TRUE(queue.Next(&tag, &ok));
  EXPECT_EQ(status.error_code(), grpc::CANCELLED);
}

TEST(Lifecycle, SessionsExpire) {
  std::atomic<std::int64_t> minutes = 0;
  test::Harness harness({.idle_timeout = 40ms, .clock = [&] {
                           return std::chrono::steady_clock::time_point(
                               std::chrono::minutes(minutes));
                         }});
  harness.create("s", test::wire_scene());
  minutes = 1;
  grpc::Status status;
  while (status.ok()) {
    grpc::ClientContext context;
    v1::ListSessionsResponse list;
    ASSERT_TRUE(harness.stub->ListSessions(&context, {}, &list).ok());
    if (list.sessions_size() > 0) continue;
    grpc::ClientContext get;
    v1::GetSessionRequest request;
    request.set_session_id("s");
    v1::GetSessionResponse response;
    status = harness.stub->GetSession(&get, request, &response);
  }
  EXPECT_EQ(status.error_code(), grpc::NOT_FOUND);
}

}  // namespace
}  // namespace stiefel
