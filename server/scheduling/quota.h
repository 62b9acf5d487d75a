#pragma once

#include <chrono>
#include <cstdint>

namespace stiefel::server {

/// The limits of one principal; 0 means no limit. Work and prices are in instructions.
struct Quota {
  std::uint32_t sessions = 0;
  /// Open Streams and Drives.
  std::uint32_t streams = 4096;
  /// Other calls that compute or wait for a worker.
  std::uint32_t calls = 4096;
  /// Bytes that sessions and calls hold.
  std::uint64_t memory = 0;
  double work_a_second = 0;
  /// The sum of the prices of all calls that run or wait.
  double queued_work = 0;
  /// The price of one call.
  double call_work = 0;
};

/// A limit that a request exceeds.
struct Refusal {
  /// The name of the limit: "principal_calls".
  const char* limit;
  /// The value that the limit allows, and the value that the request would have reached.
  double most, asked;
  /// The time after which a retry may succeed; 0 if none ever will.
  std::chrono::milliseconds retry_after;
};

}  // namespace stiefel::server
