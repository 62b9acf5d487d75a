// Calls that gRPC repeats by the client's policy, against a server that fails on purpose.
#include <gmock/gmock.h>
#include <grpcpp/server_builder.h>

#include <atomic>
#include <chrono>

#include "stiefel/client/client.h"
#include "stiefel/v1/common.pb.h"
#include "tests/client/error_of.h"

namespace stiefel::client {
namespace {

using namespace std::chrono_literals;
using grpc::StatusCode;

/// Fails the first calls.
struct Failing final : v1::SimulationService::Service {
  grpc::Status answer(grpc::ServerContext& context) {
    if (++calls > failures) return grpc::Status::OK;
    if (!pushback.empty()) context.AddTrailingMetadata("grpc-retry-pushback-ms", pushback);
    return failure;
  }
  grpc::Status Describe(grpc::ServerContext* context, const v1::DescribeRequest*,
                        v1::DescribeResponse* reply) override {
    reply->set_version("1");
    return answer(*context);
  }
  grpc::Status CreateSession(grpc::ServerContext* context, const v1::CreateSessionRequest* request,
                             v1::CreateSessionResponse* reply) override {
    reply->mutable_session()->set_session_id(request->session_id());
    return answer(*context);
  }
  /// Sends `before` samples, fails or sends the others.
  grpc::Status Stream(grpc::ServerContext* context, const v1::StreamRequest* request,
                      grpc::ServerWriter<v1::StreamResponse>* writer) override {
    const auto send = [&](std::int64_t from, std::int64_t to) {
      for (std::int64_t step = from; step < to; ++step) {
        v1::StreamResponse reply;
        reply.add_steps(step);
        reply.add_times(0);
        writer->Write(reply);
      }
    };
    send(0, before);
    const grpc::Status status = answer(*context);
    if (status.ok()) send(before, request->to() + 1);
    return status;
  }

  std::atomic<int> calls = 0;
  int failures = 0;
  grpc::Status failure = {StatusCode::UNAVAILABLE, "later"};
  std::string pushback = "1";  // milliseconds; empty: the client's own pauses
  int before = 0;
};

class RetryTest : public testing::Test {
 protected:
  RetryTest() {
    int port = 0;
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(&service_);
    builder.SetMaxReceiveMessageSize(-1);
    server_ = builder.BuildAndStart();
    address_ = "127.0.0.1:" + std::to_string(port);
  }

  Failing service_;
  std::unique_ptr<grpc::Server> server_;
  std::string address_;
};

TEST_F(RetryTest, ACallIsRepeatedWhileTheServerIsUnavailable) {
  service_.failures = 2;
  service_.pushback = "";
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(Client::connect(address_).describe().version(), "1");
  EXPECT_EQ(service_.calls, 3);
  EXPECT_GE(std::chrono::steady_clock::now() - start, 200ms) << "0.1 s and 0.3 s, less a fifth";
}

TEST_F(RetryTest, AfterFiveAttemptsTheCallHasFailed) {
  service_.failures = 1'000'000;
  const Error error = error_of([&] { Client::connect(address_).describe(); });
  EXPECT_EQ(error.code(), StatusCode::UNAVAILABLE);
  EXPECT_STREQ(error.what(), ("cannot reach " + address_ + ": later").c_str());
  EXPECT_EQ(service_.calls, 5);
}

TEST_F(RetryTest, ARefusalWithADelayIsRepeatedAfterIt) {
  service_.failures = 3;
  service_.failure = {StatusCode::RESOURCE_EXHAUSTED, "too much"};
  service_.pushback = "20";
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(Client::connect(address_).describe().version(), "1");
  EXPECT_EQ(service_.calls, 4);
  EXPECT_GE(std::chrono::steady_clock::now() - start, 60ms);
}

TEST_F(RetryTest, ARefusalForEverIsNotRepeated) {
  service_.failures = 1;
  service_.failure = {StatusCode::RESOURCE_EXHAUSTED, "too much"};
  service_.pushback = "-1";
  EXPECT_EQ(error_of([&] { Client::connect(address_).describe(); }).code(),
            StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(service_.calls, 1);
}

TEST_F(RetryTest, AWrongRequestIsNotRepeated) {
  service_.failures = 1;
  service_.failure = {StatusCode::INVALID_ARGUMENT, "no"};
  EXPECT_STREQ(error_of([&] { Client::connect(address_).describe(); }).what(), "no");
  EXPECT_EQ(service_.calls, 1);
}

TEST_F(RetryTest, APauseBeyondTheTimeoutEndsTheCall) {
  service_.failures = 1;
  service_.pushback = "3600000";
  const auto client = Client::connect(address_, {.timeout = 100ms});
  EXPECT_EQ(error_of([&] { client.describe(); }).code(), StatusCode::DEADLINE_EXCEEDED);
  EXPECT_LE(service_.calls, 1);
}

TEST_F(RetryTest, ALargeRequestIsRepeatedToo) {
  service_.failures = 2;
  v1::CreateSessionRequest request;
  request.set_session_id("large");
  request.set_checkpoint(std::string(8 << 20, 'x'));
  EXPECT_EQ(Client::connect(address_).create(request).id(), "large");
  EXPECT_EQ(service_.calls, 3);
}

TEST_F(RetryTest, AStreamIsRepeatedUntilItsFirstMessage) {
  const auto session = Client::connect(address_).create(v1::Scene());
  std::int64_t next = 0;
  const auto read = [&] {
    for (const Sample& sample : session.stream({.to = 3})) EXPECT_EQ(sample.step(), next++);
  };
  service_.calls = 0;
  service_.failures = 2;
  read();
  EXPECT_EQ(next, 4);
  EXPECT_EQ(service_.calls, 3);

  service_.calls = 0;
  service_.before = 2;
  next = 0;
  EXPECT_EQ(error_of(read).code(), StatusCode::UNAVAILABLE);
  EXPECT_EQ(next, 2) << "the samples that came before";
  EXPECT_EQ(service_.calls, 1);
}

}  // namespace
}  // namespace stiefel::client
