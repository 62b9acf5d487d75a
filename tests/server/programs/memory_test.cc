// What a server with little memory refuses, and what it gives up first.
#include <chrono>
#include <thread>

#include "tests/server/harness.h"

namespace stiefel {
namespace {

constexpr std::uint64_t MiB = 1 << 20;

template <class Detail>
Detail detail(const grpc::Status& status, const std::string& type) {
  v1::Status whole;
  EXPECT_TRUE(whole.ParseFromString(status.error_details()));
  Detail out;
  for (const auto& any : whole.details())
    if (any.type_url() == "type.googleapis.com/google.rpc." + type)
      out.ParseFromString(any.value());
  return out;
}

/// RESOURCE_EXHAUSTED of memory; whether to try again later.
void expect_refused(const grpc::Status& status, bool later) {
  ASSERT_EQ(status.error_code(), grpc::RESOURCE_EXHAUSTED) << status.error_message();
  EXPECT_EQ(detail<v1::ErrorInfo>(status, "ErrorInfo").reason(), "MEMORY_LIMIT");
  const auto quota = detail<v1::QuotaFailure>(status, "QuotaFailure");
  ASSERT_EQ(quota.violations_size(), 1);
  EXPECT_EQ(quota.violations(0).subject(), "memory");
  EXPECT_EQ(detail<v1::RetryInfo>(status, "RetryInfo").retry_delay().seconds() > 0, later);
}

class Memory : public testing::Test {
 protected:
  explicit Memory(std::uint64_t bytes = 64 * MiB) : harness_({.threads = 2, .memory = bytes}) {}

  grpc::Status create(const std::string& id, const v1::Scene& scene) {
    v1::CreateSessionRequest request;
    request.set_session_id(id);
    *request.mutable_scene() = scene;
    grpc::ClientContext context;
    v1::CreateSessionResponse response;
    return harness_.stub->CreateSession(&context, request, &response);
  }
  grpc::Status step(const std::string& id, std::int64_t to, v1::StepResponse* out = nullptr) {
    v1::StepRequest request;
    request.set_session_id(id);
    request.set_to(to);
    grpc::ClientContext context;
    v1::StepResponse response;
    return harness_.stub->Step(&context, request, out ? out : &response);
  }

  test::Harness harness_;
};

const v1::Scene body_100() { return test::wire_scene({.method = "rk4", .dimension = 100}); }

TEST_F(Memory, IsInTheLimits) {
  grpc::ClientContext context;
  v1::DescribeResponse response;
  ASSERT_TRUE(harness_.stub->Describe(&context, {}, &response).ok());
  EXPECT_EQ(response.limits().memory_bytes(), 64 * MiB);
  EXPECT_EQ(response.limits().max_message_bytes(), 4 * MiB);
}

/// Simulations and checkpoints are caches: more sessions fit than simulations, and every one goes
/// on, with the bits that it has alone.
TEST_F(Memory, CachesAreGivenUpForNewSessions) {
  int created = 0;
  grpc::Status refusal;
  for (; created < 1000; ++created) {
    refusal = create(std::to_string(created), body_100());
    if (!refusal.ok()) break;
  }
  expect_refused(refusal, true);
  EXPECT_GT(created, 25) << "11 would fit with their simulations";
  v1::StepResponse first, last;
  ASSERT_TRUE(step("0", 3, &first).ok());
  ASSERT_TRUE(step(std::to_string(created - 1), 3, &last).ok());
  const std::string expected =
      test::expected_bytes(test::scene({.method = "rk4", .dimension = 100}), 3);
  EXPECT_EQ(test::bytes_of(first.sample()), expected);
  EXPECT_EQ(test::bytes_of(last.sample()), expected);

  grpc::ClientContext context;
  v1::DeleteSessionRequest request;
  request.set_session_id("1");
  v1::DeleteSessionResponse response;
  ASSERT_TRUE(harness_.stub->DeleteSession(&context, request, &response).ok());
  EXPECT_TRUE(create("after", body_100()).ok());
}

TEST_F(Memory, WhatNeverFitsIsRefusedForGood) {
  auto scene = test::wire_scene({.method = "variational", .dimension = 100});
  scene.mutable_method()->set_order(8);
  expect_refused(create("large", scene), false);
  EXPECT_TRUE(create("small", test::wire_scene()).ok());
}

/// The simulation of an ensemble is made at its first step; a session whose first step would have
/// no room is not created.
TEST_F(Memory, MembersArePricedBeforeTheyAreMade) {
  v1::Scene scene;
  scene.set_system("rigid_body");
  scene.set_step(0.01);
  scene.set_members(Scene::max_members);
  for (const double I : {1., 2., 3.}) scene.mutable_body()->add_moments(I);
  for (const double w : {0.1, 1., 0.2}) scene.mutable_body()->add_angular_velocity(w);
  expect_refused(create("many", scene), false);
  scene.set_members(1000);
  ASSERT_TRUE(create("some", scene).ok());
  EXPECT_TRUE(step("some", 1).ok());
}

TEST_F(Memory, OfLongWorkIsTakenBeforeItBegins) {
  v1::MeasureTradeoffRequest request;
  *request.mutable_scene() = body_100();
  grpc::ClientContext context;
  const auto stream = harness_.stub->MeasureTradeoff(&context, request);
  v1::MeasureTradeoffResponse response;
  EXPECT_FALSE(stream->Read(&response));
  expect_refused(stream->Finish(), false);
}

/// A request is counted for as long as its call runs, and what is read from it too.
TEST_F(Memory, RequestsInFlightAreCounted) {
  ASSERT_TRUE(create("s", test::wire_scene()).ok());
  v1::SummarizeRequest request;
  request.set_session_id("s");
  request.set_to(1'000'000'000);
  for (int i = 0; i < 400'000; ++i) request.add_times(9e6 + i);
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<grpc::ClientReader<v1::SummarizeResponse>>> streams;
  int refused = 0;
  for (int i = 0; i < 15; ++i) {
    contexts.push_back(std::make_unique<grpc::ClientContext>());
    auto stream = harness_.stub->Summarize(contexts.back().get(), request);
    v1::SummarizeResponse progress;
    if (stream->Read(&progress)) {
      streams.push_back(std::move(stream));
      continue;
    }
    ++refused;
    expect_refused(stream->Finish(), true);
  }
  EXPECT_GE(streams.size(), 2) << "two requests of 3 MB, twice each";
  EXPECT_LE(streams.size(), 8) << "40 MiB hold no more";
  EXPECT_TRUE(step("s", 3).ok()) << "a small request is never refused";
  for (auto& context : contexts) context->TryCancel();
  for (auto& stream : streams) {
    v1::SummarizeResponse message;
    while (stream->Read(&message)) {
    }
    stream->Finish();
  }
}

/// Those that do not fit are refused, the others wait, and all of it is given back.
TEST_F(Memory, StreamsThatNobodyReads) {
  ASSERT_TRUE(create("s", body_100()).ok());
  constexpr int count = 200;
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<grpc::ClientReader<v1::StreamResponse>>> streams;
  int refused = 0;
  for (int i = 0; i < count; ++i) {
    v1::StreamRequest request;
    request.set_session_id("s");
    request.set_to(1'000'000'000);
    contexts.push_back(std::make_unique<grpc::ClientContext>());
    streams.push_back(harness_.stub->Stream(contexts.back().get(), request));
    v1::StreamResponse first;
    if (streams.back()->Read(&first)) continue;
    ++refused;
    expect_refused(streams.back()->Finish(), true);
    streams.pop_back();
    contexts.pop_back();
  }
  EXPECT_GT(refused, 0);
  EXPECT_GT(streams.size(), 20);
  for (auto& context : contexts) context->TryCancel();
  for (auto& stream : streams) {
    v1::StreamResponse message;
    while (stream->Read(&message)) {
    }
    stream->Finish();
  }
  // The server gives back what a cancelled stream held after the client has seen its end.
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  grpc::Status last = step("s", 5);
  while (last.error_code() == grpc::RESOURCE_EXHAUSTED && std::chrono::steady_clock::now() < limit)
    last = step("s", 5);
  EXPECT_TRUE(last.ok()) << last.error_message();
}

/// The state that many resting streams share is each one's own: read on, they have the right bits.
TEST_F(Memory, StreamsThatRestTogetherGoOn) {
  auto body = test::description({.method = "rk4", .dimension = 100});
  body.step = 1e-5;  // rk4 leaves the numbers at 0.01
  v1::Scene wire;
  server::to_proto(body, &wire);
  ASSERT_TRUE(create("s", wire).ok());
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<grpc::ClientReader<v1::StreamResponse>>> streams;
  for (int i = 0; i < 8; ++i) {
    v1::StreamRequest request;
    request.set_session_id("s");
    request.set_from(i % 3);
    request.set_to(40 + i);
    request.set_every(1 + i % 2);
    contexts.push_back(std::make_unique<grpc::ClientContext>());
    streams.push_back(harness_.stub->Stream(contexts.back().get(), request));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(100));  // they rest
  const Scene scene = Scene::resolve(body).value();
  for (std::size_t i = 0; i < streams.size(); ++i) {
    v1::StreamResponse message;
    std::string Q, M;
    std::int64_t last = -1;
    while (streams[i]->Read(&message)) {
      if (message.steps().empty()) continue;  // what comes after the last sample
      last = message.steps(message.steps_size() - 1);
      Q = message.fields(0).value().data();
      M = message.fields(1).value().data();
    }
    EXPECT_TRUE(streams[i]->Finish().ok());
    ASSERT_EQ(last, 40 + static_cast<std::int64_t>(i));
    const std::size_t size = 100 * 100 * sizeof(double);
    EXPECT_EQ(Q.substr(Q.size() - size) + M.substr(M.size() - size),
              test::expected_bytes(scene, last));
  }
}

}  // namespace
}  // namespace stiefel
