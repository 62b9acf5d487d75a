#pragma once

#include <grpcpp/support/status.h>

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace stiefel::v1 {
class Status;
}

namespace stiefel::client {

/// A field of a request that breaks a rule.
struct FieldViolation {
  std::string field;        ///< its path: "scene.initial.Q"
  std::string description;  ///< its value and the rule
};

/// A limit of the server that a request exceeds.
struct QuotaViolation {
  std::string subject;      ///< the name of the limit: "sessions"
  std::string description;  ///< the limit, and the value that the request would have led to
};

/// A call that failed: a wrong request, or a server that cannot be reached. Numerical stops are not
/// errors; they are the `run_status` of a reply.
class Error : public std::runtime_error {
 public:
  explicit Error(const grpc::Status& status);
  /// `status`: the error in a reply of Drive.
  explicit Error(const v1::Status& status);
  /// `details`: a serialized stiefel.v1.Status, as in grpc-status-details-bin; may be empty.
  Error(grpc::StatusCode code, const std::string& message, const std::string& details = "");

  grpc::StatusCode code() const { return code_; }
  /// All fields of the request that break a rule.
  const std::vector<FieldViolation>& violations() const { return violations_; }
  /// The limits that the request exceeds, with RESOURCE_EXHAUSTED.
  const std::vector<QuotaViolation>& quota_violations() const { return quota_violations_; }
  /// The least time after which the same request may succeed, if the server sent one.
  std::optional<std::chrono::nanoseconds> retry_delay() const { return retry_delay_; }
  /// A constant in UPPER_SNAKE_CASE such as "SESSION_NOT_FOUND"; empty if the server sent none.
  const std::string& reason() const { return reason_; }
  const std::map<std::string, std::string>& metadata() const { return metadata_; }

 private:
  void read(const v1::Status& status);

  grpc::StatusCode code_;
  std::vector<FieldViolation> violations_;
  std::vector<QuotaViolation> quota_violations_;
  std::optional<std::chrono::nanoseconds> retry_delay_;
  std::string reason_;
  std::map<std::string, std::string> metadata_;
};

/// Returns the error of a call on a session that its handle has deleted. The code is NOT_FOUND, the
/// reason SESSION_DELETED.
Error session_deleted(const std::string& session_id);

/// Thrown when a server of another build answers for a session: its states could have other bits
/// than those so far. The code is FAILED_PRECONDITION, the reason BUILD_CHANGED.
class BuildChanged : public Error {
 public:
  BuildChanged(const std::string& session_id, std::string began_with, std::string now);

  /// The numerics id of the server that created the session.
  const std::string& began_with() const { return began_with_; }
  /// The numerics id of the server that answered.
  const std::string& now() const { return now_; }

 private:
  std::string began_with_;
  std::string now_;
};

/// Thrown for a reply that breaks the protocol: a field or a part of it is missing, or has a wrong
/// shape. The code is DATA_LOSS.
class CorruptReply : public Error {
 public:
  explicit CorruptReply(const std::string& message) : Error(grpc::StatusCode::DATA_LOSS, message) {}
};

}  // namespace stiefel::client
