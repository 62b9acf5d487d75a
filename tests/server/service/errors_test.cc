// Errors that no single wrong field is: floods of them, limits, routing and checkpoints.
// tests/conformance has those of fields.
#include <functional>

#include "server/convert/errors.h"
#include "tests/server/harness.h"

namespace stiefel {
namespace {

class Errors : public testing::Test {
 protected:
  Errors() { harness_.create("s", test::wire_scene()); }

  grpc::Status create(const std::function<void(v1::CreateSessionRequest&)>& change) {
    v1::CreateSessionRequest request;
    request.set_session_id("new");
    *request.mutable_scene() = test::wire_scene();
    change(request);
    grpc::ClientContext context;
    v1::CreateSessionResponse response;
    return harness_.stub->CreateSession(&context, request, &response);
  }
  grpc::Status create_scene(const std::function<void(v1::Scene&)>& change) {
    return create([&](v1::CreateSessionRequest& request) { change(*request.mutable_scene()); });
  }
  ~Errors() override {
    EXPECT_EQ(harness_.step("s", 10).sample().step(), 10) << "the server lives";
  }

  test::Harness harness_;
};

/// INVALID_ARGUMENT with a violation of the field, in the details and in the message.
void expect_invalid(const grpc::Status& status, const std::string& field) {
  EXPECT_EQ(status.error_code(), grpc::INVALID_ARGUMENT) << field << ": " << status.error_message();
  EXPECT_NE(status.error_message().find(field + ": "), std::string::npos) << status.error_message();
  v1::Status details;
  ASSERT_TRUE(details.ParseFromString(status.error_details())) << field;
  ASSERT_EQ(details.details_size(), 1) << field;
  EXPECT_EQ(details.details(0).type_url(), "type.googleapis.com/google.rpc.BadRequest");
  v1::BadRequest bad;
  ASSERT_TRUE(bad.ParseFromString(details.details(0).value()));
  const bool named = std::ranges::any_of(bad.field_violations(), [&](const auto& violation) {
    return violation.field() == field && !violation.description().empty();
  });
  EXPECT_TRUE(named) << field << " in " << bad.ShortDebugString();
}

void expect_reason(const grpc::Status& status, grpc::StatusCode code, const std::string& reason) {
  EXPECT_EQ(status.error_code(), code) << status.error_message();
  v1::Status details;
  ASSERT_TRUE(details.ParseFromString(status.error_details()));
  ASSERT_GE(details.details_size(), 1);
  EXPECT_EQ(details.details(0).type_url(), "type.googleapis.com/google.rpc.ErrorInfo");
  v1::ErrorInfo info;
  ASSERT_TRUE(info.ParseFromString(details.details(0).value()));
  EXPECT_EQ(info.reason(), reason);
  EXPECT_EQ(info.domain(), "stiefel");
}

TEST_F(Errors, AFloodOfViolationsFitsInTheTrailers) {
  constexpr std::size_t blocks = 50;  // each without rows and without columns
  const auto status = create_scene([](v1::Scene& scene) {
    scene.clear_initial();
    for (std::size_t i = 0; i < blocks; ++i)
      (*scene.mutable_initial())[std::string(300, 'x') + std::to_string(i)];
  });
  EXPECT_EQ(status.error_code(), grpc::INVALID_ARGUMENT);
  const std::string& message = status.error_message();
  EXPECT_LT(message.size() + status.error_details().size(), 7000u);
  const std::size_t end = message.rfind("; and ");
  ASSERT_NE(end, std::string::npos) << message;
  const auto told = 1 + std::ranges::count(message.substr(0, end), ';');
  EXPECT_EQ(static_cast<std::size_t>(told) + std::stoul(message.substr(end + 6)), 2 * blocks);
}

TEST_F(Errors, MoreBlocksThanAnySystemHas) {
  const auto status = create_scene([](v1::Scene& scene) {
    for (int i = 0; i < 100; ++i) (*scene.mutable_initial())[std::to_string(i) + "x"];
  });
  expect_invalid(status, "scene.initial");
}

TEST(ErrorsOfResources, SayWhichQuotaAndWhenToRetry) {
  const auto expect = [](const grpc::Status& status, const char* reason, const char* subject) {
    expect_reason(status, grpc::RESOURCE_EXHAUSTED, reason);
    v1::Status details;
    ASSERT_TRUE(details.ParseFromString(status.error_details()));
    ASSERT_EQ(details.details_size(), 3) << reason;
    EXPECT_EQ(details.details(1).type_url(), "type.googleapis.com/google.rpc.QuotaFailure");
    v1::QuotaFailure quota;
    ASSERT_TRUE(quota.ParseFromString(details.details(1).value()));
    ASSERT_EQ(quota.violations_size(), 1);
    EXPECT_EQ(quota.violations(0).subject(), subject);
    EXPECT_EQ(server::errors::retry_delay(status), std::chrono::seconds(1)) << reason;
  };
  using Fault = server::WriteFault;
  expect(server::errors::out_of_memory(), "OUT_OF_MEMORY", "memory");
  expect(server::errors::not_written(Fault{Fault::Kind::full, "no space"}), "STORE_FULL", "store");
  expect(server::errors::not_written(Fault{Fault::Kind::out_of_memory, ""}), "OUT_OF_MEMORY",
         "memory");
}

TEST_F(Errors, OfRouting) {
  const auto routed = [&](const std::vector<std::string>& by) {
    v1::StepRequest request;
    request.set_session_id("s");
    grpc::ClientContext context;
    for (const std::string& name : by) context.AddMetadata("stiefel-session", name);
    v1::StepResponse response;
    return harness_.stub->Step(&context, request, &response);
  };
  EXPECT_TRUE(routed({}).ok());
  EXPECT_TRUE(routed({"s"}).ok());
  EXPECT_TRUE(routed({"s", "s"}).ok());
  for (const std::vector<std::string>& by :
       {std::vector<std::string>{"t"}, {"s", "t"}, {"t", "s"}, {"s", ""}})
    expect_invalid(routed(by), "session_id");
}

}  // namespace
}  // namespace stiefel
