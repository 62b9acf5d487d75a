// The limits of principals over the wire: what is refused, by which name, and when to come back.
#include <thread>

#include "tests/server/quota.h"

namespace stiefel {
namespace {

using namespace test;

TEST(Quotas, CallsAtOnce) {
  test::Harness harness(by_name({.quota = {.calls = 2}}));
  for (const char* principal : {"greedy", "modest"}) create_as(*harness.stub, principal, "s");
  std::vector<std::unique_ptr<Running>> calls;
  // A Step is refused once two calls have arrived; one of them may have been refused itself, while
  // a Step had its place.
  std::int64_t far = 0;
  grpc::Status status;
  for (int attempt = 0; status.ok() && attempt < 1000; ++attempt) {
    calls.push_back(std::make_unique<Running>(*harness.stub, "greedy"));
    grpc::ClientContext context;
    status = step_as(*harness.stub, "greedy", far += 100'000, context);
    if (!status.ok()) expect_refused(told(status, context), "principal_calls");
  }
  EXPECT_FALSE(status.ok());
  grpc::ClientContext other;
  EXPECT_TRUE(step_as(*harness.stub, "modest", far += 100'000, other).ok())
      << "another principal's";
  calls.clear();
  for (int attempt = 0; !status.ok() && attempt < 1000; ++attempt) {  // until the places are free
    grpc::ClientContext context;
    status = step_as(*harness.stub, "greedy", far += 100'000, context);
    if (!status.ok()) std::this_thread::sleep_for(10ms);
  }
  EXPECT_TRUE(status.ok()) << status.error_message();
}

TEST(Quotas, StreamsAndDrivesAtOnce) {
  test::Harness harness(by_name({.quota = {.calls = 1}}));
  harness.create("s", test::wire_scene());
  v1::DriveRequest request;
  request.set_session_id("s");
  request.set_to(5);
  v1::DriveResponse response;
  std::unique_ptr<grpc::ClientContext> first_context;
  std::unique_ptr<grpc::ClientReaderWriter<v1::DriveRequest, v1::DriveResponse>> first;
  for (bool served = false; !served;) {  // the creation leaves its place after its reply
    first_context = std::make_unique<grpc::ClientContext>();
    first = harness.stub->Drive(first_context.get());
    served = first->Write(request) && first->Read(&response);
    if (!served) expect_refused(told(first->Finish(), *first_context), "principal_calls");
  }
  EXPECT_EQ(response.step().sample().step(), 5);

  grpc::ClientContext second_context;
  const auto second = harness.stub->Drive(&second_context);
  EXPECT_FALSE(second->Read(&response));
  expect_refused(told(second->Finish(), second_context), "principal_calls");

  v1::StreamRequest stream;
  stream.set_session_id("s");
  stream.set_to(5);
  grpc::ClientContext third_context;
  const auto third = harness.stub->Stream(&third_context, stream);
  v1::StreamResponse message;
  EXPECT_FALSE(third->Read(&message));
  expect_refused(told(third->Finish(), third_context), "principal_calls");

  first->WritesDone();
  EXPECT_TRUE(first->Finish().ok());
  for (bool served = false; !served;) {
    grpc::ClientContext context;
    const auto again = harness.stub->Stream(&context, stream);
    served = again->Read(&message);
    while (again->Read(&message)) {
    }
    again->Finish();
  }
}

TEST(Quotas, Sessions) {
  test::Harness harness(by_name({.quota = {.sessions = 1}}));
  const auto create = [&](const std::string& principal, const std::string& id,
                          grpc::ClientContext& context) {
    context.AddMetadata("x-principal", principal);
    v1::CreateSessionRequest request;
    request.set_session_id(id);
    *request.mutable_scene() = test::wire_scene();
    v1::CreateSessionResponse response;
    return harness.stub->CreateSession(&context, request, &response);
  };
  const auto created = [&](const std::string& principal, const std::string& id) {
    grpc::ClientContext context;
    return create(principal, id, context).ok();
  };
  EXPECT_TRUE(created("alice", "a"));
  EXPECT_TRUE(created("alice", "a")) << "the session that is there takes no other slot";
  grpc::ClientContext context;
  expect_refused(told(create("alice", "b", context), context), "principal_sessions");
  EXPECT_TRUE(created("bob", "b"));
  EXPECT_FALSE(created("alice", "b")) << "bob's is another session";

  v1::ForkSessionRequest fork;
  fork.set_session_id("c");
  fork.set_from_session_id("a");
  grpc::ClientContext fork_context;
  fork_context.AddMetadata("x-principal", "alice");
  v1::ForkSessionResponse forked;
  const auto status = harness.stub->ForkSession(&fork_context, fork, &forked);
  expect_refused(told(status, fork_context), "principal_sessions");

  v1::DeleteSessionRequest gone;
  gone.set_session_id("a");
  grpc::ClientContext delete_context;
  delete_context.AddMetadata("x-principal", "alice");
  v1::DeleteSessionResponse deleted;
  EXPECT_TRUE(harness.stub->DeleteSession(&delete_context, gone, &deleted).ok());
  EXPECT_TRUE(created("alice", "c")) << "the slot is free";
}

TEST(Quotas, TheTimeOfOneCall) {
  test::Harness harness({.quota = {.call_seconds = 0.05}});
  harness.create("s", test::wire_scene());
  grpc::ClientContext small, large;
  EXPECT_TRUE(step(*harness.stub, small, 1000).ok());
  const auto status = step(*harness.stub, large, forever);
  const Told refusal = told(status, large);
  EXPECT_EQ(refusal.limit, "call_seconds");
  EXPECT_FALSE(refusal.delay) << "to wait does not help";
  EXPECT_EQ(refusal.push_back, "-1");
  EXPECT_NE(status.error_message().find("the limit is 0.05 s"), std::string::npos)
      << status.error_message();
}

TEST(Quotas, AStreamThatHasComputedForItsTimeSendsWhereItStopped) {
  test::Harness harness({.quota = {.call_seconds = 0.05}});
  harness.create("s", test::wire_scene());
  grpc::ClientContext context;
  v1::StreamRequest request;
  request.set_session_id("s");
  request.set_to(forever);
  request.set_every(1'000'000'000);
  request.set_return_checkpoint(true);
  const auto stream = harness.stub->Stream(&context, request);
  std::string checkpoint;
  std::int64_t reached = 0;
  for (v1::StreamResponse message; stream->Read(&message);) {
    reached = message.checkpoint().step();
    checkpoint += message.checkpoint().data();
  }
  EXPECT_EQ(told(stream->Finish(), context).limit, "call_seconds");
  EXPECT_GT(reached, 1000);
  v1::CreateSessionRequest again;
  again.set_session_id("t");
  *again.mutable_scene() = test::wire_scene();
  again.set_checkpoint(checkpoint);
  grpc::ClientContext create;
  v1::CreateSessionResponse made;
  EXPECT_TRUE(harness.stub->CreateSession(&create, again, &made).ok());
  EXPECT_EQ(harness.step("t", reached + 1).computed_steps(), 1);
}

TEST(Quotas, ASummaryThatHasComputedForItsTimeSendsACheckpointAndGoesOn) {
  test::Harness harness({.quota = {.call_seconds = 0.05}});
  harness.create("s", test::wire_scene());
  v1::SummarizeRequest request;
  request.set_session_id("s");
  request.set_to(forever);
  request.set_every(1'000'000);
  request.set_return_checkpoint(true);
  std::int64_t before = 0;
  for (int calls = 0; calls < 2; ++calls) {
    grpc::ClientContext context;
    const auto stream = harness.stub->Summarize(&context, request);
    request.clear_checkpoint();
    std::int64_t reached = 0;
    for (v1::SummarizeResponse message; stream->Read(&message);) {
      reached = message.step();
      request.mutable_checkpoint()->append(message.checkpoint().data());
    }
    EXPECT_EQ(told(stream->Finish(), context).limit, "call_seconds");
    EXPECT_GT(reached, before);
    before = reached;
    ASSERT_FALSE(request.checkpoint().empty());
  }
}

TEST(Quotas, DrivesAreToldInTheirReplies) {
  test::Harness harness({.quota = {.call_seconds = 0.05}});
  harness.create("s", test::wire_scene());
  grpc::ClientContext context;
  const auto drive = harness.stub->Drive(&context);
  v1::DriveRequest request;
  request.set_session_id("s");
  request.set_to(forever);
  v1::DriveResponse response;
  ASSERT_TRUE(drive->Write(request) && drive->Read(&response));
  EXPECT_EQ(response.error().code(), grpc::RESOURCE_EXHAUSTED);
  EXPECT_EQ(told(response.error()).limit, "call_seconds");
  request.set_to(1);
  ASSERT_TRUE(drive->Write(request) && drive->Read(&response));
  EXPECT_EQ(response.step().sample().step(), 1) << "the call goes on";
  drive->WritesDone();
  EXPECT_TRUE(drive->Finish().ok());
}

TEST(Quotas, Memory) {
  constexpr std::uint64_t limit = 2 << 20;
  test::Harness harness(by_name({.quota = {.memory = limit}}));
  const auto create = [&](const std::string& principal, int number, int n,
                          grpc::ClientContext& context) {
    context.AddMetadata("x-principal", principal);
    v1::CreateSessionRequest request;
    request.set_session_id(std::to_string(number));
    *request.mutable_scene() = test::wire_scene({.dimension = n});
    v1::CreateSessionResponse response;
    return harness.stub->CreateSession(&context, request, &response);
  };
  int made = 0;
  Told refusal;
  for (bool refused = false; !refused && made < 10'000;) {
    grpc::ClientContext context;
    const auto status = create("greedy", made, 8, context);
    refused = !status.ok();
    if (refused)
      expect_refused(refusal = told(status, context), "principal_memory");
    else
      ++made;
  }
  EXPECT_GT(made, 10);
  EXPECT_LT(made, 2000) << "a session takes a kilobyte or more";
  EXPECT_EQ(refusal.delay, 1s);
  grpc::ClientContext never;
  const Told too_large = told(create("modest", 0, 64, never), never);
  EXPECT_EQ(too_large.limit, "principal_memory");
  EXPECT_FALSE(too_large.delay) << "it does not fit into the whole quota";
  grpc::ClientContext other;
  EXPECT_TRUE(create("modest", 1, 8, other).ok()) << "another principal's bytes";

  // A call gives its bytes back a moment after its reply.
  const auto comes_to_pass = [](const auto& call) {
    grpc::Status status(grpc::RESOURCE_EXHAUSTED, "");
    for (int i = 0; i < 1000 && status.error_code() == grpc::RESOURCE_EXHAUSTED; ++i) {
      if (i > 0) std::this_thread::sleep_for(10ms);
      grpc::ClientContext context;
      status = call(context);
    }
    EXPECT_TRUE(status.ok()) << status.error_message();
  };
  // With the bytes of all sessions taken each still steps: the caches of the others are given up.
  for (int i = 0; i < made; i += 7) {
    comes_to_pass([&](grpc::ClientContext& context) {
      context.AddMetadata("x-principal", "greedy");
      v1::StepRequest request;
      request.set_session_id(std::to_string(i));
      request.set_to(3);
      v1::StepResponse response;
      return harness.stub->Step(&context, request, &response);
    });
  }

  for (int i = 0; i < 3; ++i) {
    v1::DeleteSessionRequest gone;
    gone.set_session_id(std::to_string(i));
    grpc::ClientContext context;
    context.AddMetadata("x-principal", "greedy");
    v1::DeleteSessionResponse deleted;
    EXPECT_TRUE(harness.stub->DeleteSession(&context, gone, &deleted).ok());
  }
  comes_to_pass([&](grpc::ClientContext& context) { return create("greedy", 0, 8, context); });
}

}  // namespace
}  // namespace stiefel
