#include "stiefel/client/error.h"

#include <algorithm>

#include "stiefel/v1/common.pb.h"

namespace stiefel::client {
namespace {

/// Parses `any` if it has the type `name`. Any::UnpackTo cannot do this, because it compares type
/// names, and the details travel under those of google.rpc.
template <class Message>
bool unpack(const google::protobuf::Any& any, std::string_view name, Message& message) {
  const std::string_view url = any.type_url();
  return url.substr(url.rfind('/') + 1) == name && message.ParseFromString(any.value());
}

}  // namespace

Error::Error(const grpc::Status& status)
    : std::runtime_error(status.error_message()), code_(status.error_code()) {
  v1::Status details;
  if (details.ParseFromString(status.error_details())) read(details);
}

Error::Error(const v1::Status& status)
    : std::runtime_error(status.message()), code_(static_cast<grpc::StatusCode>(status.code())) {
  read(status);
}

void Error::read(const v1::Status& status) {
  for (const auto& any : status.details()) {
    v1::BadRequest bad_request;
    if (unpack(any, "google.rpc.BadRequest", bad_request)) {
      for (const auto& violation : bad_request.field_violations())
        violations_.push_back({violation.field(), violation.description()});
    }
    v1::QuotaFailure quota;
    if (unpack(any, "google.rpc.QuotaFailure", quota)) {
      for (const auto& violation : quota.violations())
        violations_.push_back({violation.subject(), violation.description()});
    }
    v1::RetryInfo retry;
    if (unpack(any, "google.rpc.RetryInfo", retry)) {
      // Any number may come; 2^33 s is less than the longest std::chrono::nanoseconds.
      const auto seconds = std::clamp<std::int64_t>(retry.retry_delay().seconds(), 0, 1LL << 33);
      retry_delay_ = std::chrono::seconds(seconds) +
                     std::chrono::nanoseconds(std::max(retry.retry_delay().nanos(), 0));
    }
    v1::ErrorInfo info;
    if (unpack(any, "google.rpc.ErrorInfo", info)) {
      reason_ = info.reason();
      metadata_ = {info.metadata().begin(), info.metadata().end()};
    }
  }
}

}  // namespace stiefel::client
