// Callers of several principals, and what a refusal tells them.
#pragma once

#include <atomic>
#include <chrono>
#include <optional>
#include <string>

#include "tests/server/harness.h"

namespace stiefel::test {

using namespace std::chrono_literals;
constexpr std::int64_t forever = 1'000'000'000'000;

/// Takes as principal what the metadata `x-principal` names.
inline server::Options by_name(server::Options options) {
  options.identify = [](const grpc::ServerContextBase& context) {
    const auto sent = context.client_metadata().find("x-principal");
    if (sent == context.client_metadata().end()) return server::Principal{};
    return server::Principal{std::string(sent->second.data(), sent->second.size())};
  };
  return options;
}

/// What a refusal says, in its details and its trailing metadata.
struct Told {
  std::string limit;
  std::optional<std::chrono::milliseconds> delay;
  std::string push_back;
};

inline Told told(const v1::Status& status) {
  Told told;
  for (const auto& any : status.details()) {
    v1::QuotaFailure quota;
    v1::RetryInfo retry;
    if (any.type_url() == "type.googleapis.com/google.rpc.QuotaFailure") {
      EXPECT_TRUE(quota.ParseFromString(any.value()));
      EXPECT_EQ(quota.violations_size(), 1);
      told.limit = quota.violations(0).subject();
      EXPECT_NE(quota.violations(0).description().find("the limit is"), std::string::npos);
    } else if (any.type_url() == "type.googleapis.com/google.rpc.RetryInfo") {
      EXPECT_TRUE(retry.ParseFromString(any.value()));
      told.delay = std::chrono::seconds(retry.retry_delay().seconds()) +
                   std::chrono::milliseconds(retry.retry_delay().nanos() / 1'000'000);
    }
  }
  return told;
}

inline Told told(const grpc::Status& status, const grpc::ClientContext& context) {
  EXPECT_EQ(status.error_code(), grpc::RESOURCE_EXHAUSTED) << status.error_message();
  v1::Status details;
  EXPECT_TRUE(details.ParseFromString(status.error_details()));
  Told result = told(details);
  const auto sent = context.GetServerTrailingMetadata().find("grpc-retry-pushback-ms");
  if (sent != context.GetServerTrailingMetadata().end())
    result.push_back = {sent->second.data(), sent->second.size()};
  return result;
}

inline void expect_refused(const Told& told, const std::string& limit) {
  EXPECT_EQ(told.limit, limit);
  ASSERT_TRUE(told.delay) << limit;
  EXPECT_GE(*told.delay, 1ms);
  EXPECT_LE(*told.delay, 1min);
  EXPECT_EQ(told.push_back, std::to_string(told.delay->count()));
}

/// A Step that does not end by itself, until it is destroyed.
class Running {
 public:
  Running(Stub& stub, const std::string& principal, std::int64_t to = forever) {
    context.AddMetadata("x-principal", principal);
    request_.set_session_id("s");
    request_.set_to(to);
    stub.async()->Step(&context, &request_, &response, [this](const grpc::Status& ended) {
      status = ended;
      done_ = true;
      done_.notify_all();
    });
  }
  ~Running() {
    context.TryCancel();
    wait();
  }
  void wait() { done_.wait(false); }
  bool done() const { return done_; }

  grpc::ClientContext context;
  grpc::Status status;
  v1::StepResponse response;

 private:
  v1::StepRequest request_;
  std::atomic<bool> done_ = false;
};

inline grpc::Status step(Stub& stub, grpc::ClientContext& context, std::int64_t to) {
  v1::StepRequest request;
  request.set_session_id("s");
  request.set_to(to);
  v1::StepResponse response;
  return stub.Step(&context, request, &response);
}

inline void create_as(Stub& stub, const std::string& principal, const std::string& id) {
  grpc::ClientContext context;
  context.AddMetadata("x-principal", principal);
  v1::CreateSessionRequest request;
  request.set_session_id(id);
  *request.mutable_scene() = wire_scene();
  v1::CreateSessionResponse response;
  EXPECT_TRUE(stub.CreateSession(&context, request, &response).ok());
}

inline grpc::Status step_as(Stub& stub, const std::string& principal, std::int64_t to,
                            grpc::ClientContext& context) {
  context.AddMetadata("x-principal", principal);
  return step(stub, context, to);
}

}  // namespace stiefel::test
