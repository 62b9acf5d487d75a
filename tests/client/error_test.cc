// What an Error reads of a status and its details.
#include <gtest/gtest.h>

#include "stiefel/client/error.h"
#include "stiefel/v1/common.pb.h"

namespace stiefel::client {
namespace {

TEST(ErrorTest, ReadsQuotaAndDelay) {
  v1::QuotaFailure quota;
  quota.add_violations()->set_subject("sessions");
  v1::RetryInfo retry;
  retry.mutable_retry_delay()->set_seconds(1);
  retry.mutable_retry_delay()->set_nanos(500'000'000);
  v1::Status status;
  status.set_code(grpc::StatusCode::RESOURCE_EXHAUSTED);
  status.set_message("too many");
  status.add_details()->set_type_url("type.googleapis.com/google.rpc.QuotaFailure");
  status.mutable_details(0)->set_value(quota.SerializeAsString());
  status.add_details()->set_type_url("type.googleapis.com/google.rpc.RetryInfo");
  status.mutable_details(1)->set_value(retry.SerializeAsString());
  const Error error(status);
  EXPECT_EQ(error.code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_STREQ(error.what(), "too many");
  ASSERT_EQ(error.violations().size(), 1u);
  EXPECT_EQ(error.violations()[0].field, "sessions");
  EXPECT_EQ(error.retry_delay(), std::chrono::milliseconds(1500));
}

TEST(ErrorTest, ReadsTheDetailsUnderGooglesNames) {
  v1::BadRequest bad;
  auto* violation = bad.add_field_violations();
  violation->set_field("initial.Q");
  violation->set_description("2 x 3: must be square");
  v1::ErrorInfo info;
  info.set_reason("BAD");
  (*info.mutable_metadata())["key"] = "value";
  v1::Status status;
  auto* any = status.add_details();
  any->set_type_url("type.googleapis.com/google.rpc.BadRequest");
  any->set_value(bad.SerializeAsString());
  any = status.add_details();
  any->set_type_url("type.googleapis.com/google.rpc.ErrorInfo");
  any->set_value(info.SerializeAsString());

  const Error error(
      grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "text", status.SerializeAsString()));
  EXPECT_STREQ(error.what(), "text");
  ASSERT_EQ(error.violations().size(), 1u);
  EXPECT_EQ(error.violations()[0].field, "initial.Q");
  EXPECT_EQ(error.violations()[0].description, "2 x 3: must be square");
  EXPECT_EQ(error.reason(), "BAD");
  EXPECT_EQ(error.metadata().at("key"), "value");
}

TEST(ErrorTest, StandsWithoutReadableDetails) {
  const Error error(grpc::Status(grpc::StatusCode::INTERNAL, "text", "\xff\xff not a message"));
  EXPECT_EQ(error.code(), grpc::StatusCode::INTERNAL);
  EXPECT_TRUE(error.violations().empty());
  EXPECT_TRUE(error.reason().empty());
}

}  // namespace
}  // namespace stiefel::client
