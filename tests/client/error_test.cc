// What an Error reads of a status and its details.
#include <gtest/gtest.h>

#include "stiefel/client/error.h"
#include "stiefel/v1/common.pb.h"

namespace stiefel::client {
namespace {

void add(v1::Status& status, const std::string& kind, const google::protobuf::Message& detail) {
  auto* any = status.add_details();
  any->set_type_url("type.googleapis.com/google.rpc." + kind);
  any->set_value(detail.SerializeAsString());
}

TEST(ErrorTest, ReadsTheDetailsUnderGooglesNames) {
  v1::BadRequest bad;
  bad.add_field_violations()->set_field("initial.Q");
  bad.mutable_field_violations(0)->set_description("2 x 3: must be square");
  v1::QuotaFailure quota;
  quota.add_violations()->set_subject("sessions");
  v1::RetryInfo retry;
  retry.mutable_retry_delay()->set_seconds(1);
  retry.mutable_retry_delay()->set_nanos(500'000'000);
  v1::ErrorInfo info;
  info.set_reason("BAD");
  (*info.mutable_metadata())["key"] = "value";
  v1::Status status;
  status.set_code(grpc::StatusCode::RESOURCE_EXHAUSTED);
  status.set_message("too many");
  add(status, "BadRequest", bad);
  add(status, "QuotaFailure", quota);
  add(status, "RetryInfo", retry);
  add(status, "ErrorInfo", info);
  const grpc::Status call(grpc::StatusCode::RESOURCE_EXHAUSTED, "too many",
                          status.SerializeAsString());
  for (const Error& error : {Error(status), Error(call)}) {
    EXPECT_EQ(error.code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
    EXPECT_STREQ(error.what(), "too many");
    ASSERT_EQ(error.violations().size(), 2u);
    EXPECT_EQ(error.violations()[0].field, "initial.Q");
    EXPECT_EQ(error.violations()[0].description, "2 x 3: must be square");
    EXPECT_EQ(error.violations()[1].field, "sessions");
    EXPECT_EQ(error.retry_delay(), std::chrono::milliseconds(1500));
    EXPECT_EQ(error.reason(), "BAD");
    EXPECT_EQ(error.metadata().at("key"), "value");
  }
}

TEST(ErrorTest, StandsWithoutReadableDetails) {
  const Error error(grpc::Status(grpc::StatusCode::INTERNAL, "text", "\xff\xff not a message"));
  EXPECT_EQ(error.code(), grpc::StatusCode::INTERNAL);
  EXPECT_TRUE(error.violations().empty());
  EXPECT_TRUE(error.reason().empty());
}

}  // namespace
}  // namespace stiefel::client
