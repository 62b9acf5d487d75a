#pragma once

#include <chrono>
#include <cstdint>

namespace stiefel::server {

/// The limits of one principal; 0: no limit. Work is in instructions, as prices are.
struct Quota {
  std::uint32_t sessions = 0;
  /// Streams and Drives that are open.
  std::uint32_t streams = 4096;
  /// Other calls that compute, those that wait for a worker included.
  std::uint32_t calls = 4096;
  /// Bytes that sessions and calls hold.
  std::uint64_t memory = 0;
  double work_a_second = 0;
  /// The prices of all calls that run or wait, together.
  double queued_work = 0;
  /// The price of one call.
  double call_work = 0;
};

/// A limit that a request exceeds.
struct Refusal {
  /// The name of the limit: "principal_calls".
  const char* limit;
  /// What is allowed, and what the request would have made of it.
  double most, asked;
  /// When it may succeed; 0: never, however long the caller waits.
  std::chrono::milliseconds retry_after;
};

}  // namespace stiefel::server
