#pragma once

#include <chrono>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>

namespace stiefel::server {

/// Who calls: sessions, quotas and shares belong to a principal. The name is empty for every caller
/// of a server without tokens.
struct Principal {
  std::string name;

  auto operator<=>(const Principal&) const = default;
};

/// The most calls of a server at once: each has a thread.
inline constexpr std::uint32_t most_calls = 900;

/// The limits of one principal; 0 means no limit.
struct Quota {
  /// If not set, that of `with_shares`.
  std::optional<std::uint32_t> sessions = std::nullopt;
  /// Calls at once, Streams and Drives included. If not set, that of `with_shares`.
  std::uint32_t calls = 0;
  /// Bytes that sessions and calls hold. If not set, that of `with_shares`.
  std::optional<std::uint64_t> memory = std::nullopt;
  /// The seconds for which one call, or one request of a Drive, may compute.
  double call_seconds = 0;
};

/// Returns the limits with those that are not set: half of the server's `sessions` and `memory` if
/// there may be several principals, so that none takes all of them from the others; otherwise no
/// limit.
inline Quota with_shares(Quota quota, bool several, std::uint32_t sessions, std::uint64_t memory) {
  if (!quota.sessions) quota.sessions = several ? (sessions + 1) / 2 : 0;
  if (!quota.memory) quota.memory = several ? memory / 2 : 0;
  if (quota.calls == 0 && several) quota.calls = most_calls / 2;
  return quota;
}

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
