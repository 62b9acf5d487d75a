#pragma once

#include <grpcpp/support/status.h>

#include "server/convert/parts.h"
#include "stiefel/conversion.h"
#include "stiefel/v1/conversion.pb.h"

namespace stiefel::server {

/// Returns a conversion's refusal as an error status.
grpc::Status refused(const ConversionRefusal& refusal);

/// Answers a Convert in messages of limited size.
class ConversionAnswer {
 public:
  /// `memory`: the bytes that the call holds.
  ConversionAnswer(const v1::ConvertRequest& request, std::uint64_t memory)
      : request_(request), memory_(memory) {}

  /// Writes the next message over `response`; the first call converts.
  grpc::Status next(v1::ConvertResponse& response);
  bool done() const { return started_ && scene_arrays_.empty() && blocks_.empty(); }

 private:
  grpc::Status convert(v1::ConvertResponse& response);

  const v1::ConvertRequest& request_;
  const std::uint64_t memory_;
  bool started_ = false;
  Parts scene_arrays_, blocks_;
};

}  // namespace stiefel::server
