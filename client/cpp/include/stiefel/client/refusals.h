#pragma once

#include <grpcpp/support/status.h>

#include <chrono>
#include <optional>

namespace stiefel::client {

/// The pauses of one call that a server refuses with RESOURCE_EXHAUSTED and the time after which it
/// may succeed: that time and a random one of up to 10, 20, 40 ... 1000 ms, so that callers refused
/// together do not come back together. Repetitions for other reasons do not count here, and these
/// not there, so a call has at most the sum of both attempts.
class Refusals {
 public:
  static constexpr int most = 64;

  /// The pause before the next attempt; none if the status is no such refusal, or there were `most`
  /// of them.
  std::optional<std::chrono::milliseconds> next(const grpc::Status& status);

 private:
  int count_ = 0;
};

}  // namespace stiefel::client
