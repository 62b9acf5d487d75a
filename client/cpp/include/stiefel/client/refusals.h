#pragma once

#include <grpcpp/support/status.h>

#include <chrono>
#include <optional>

namespace stiefel::client {

/// The pauses of a call that the server refuses with RESOURCE_EXHAUSTED and a retry delay. Each
/// pause is that delay plus a random time of up to 10, 20, 40 ... 1000 ms, so that callers refused
/// together do not come back together. A refusal with a longer delay than `longest` ends the call.
/// These repetitions and those after UNAVAILABLE are counted
/// separately.
class Refusals {
 public:
  static constexpr int most = 64;
  static constexpr std::chrono::seconds longest{300};

  /// Returns the pause before the next attempt; nothing if the status is not a refusal with a retry
  /// delay of at most `longest`, or if there were `most` refusals.
  std::optional<std::chrono::milliseconds> next(const grpc::Status& status);

 private:
  int count_ = 0;
};

}  // namespace stiefel::client
