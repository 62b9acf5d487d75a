#pragma once

#include <grpcpp/support/status.h>

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace stiefel::client {

/// One field of a request that breaks a rule: its path ("scene.initial.Q"), and its value with the
/// rule.
struct FieldViolation {
  std::string field;
  std::string description;
};

/// A call that failed: a wrong request, or a server that cannot be reached. Numerical stops are not
/// errors; they are the `run_status` of a reply.
class Error : public std::runtime_error {
 public:
  explicit Error(const grpc::Status& status);
  /// `details`: a serialized stiefel.v1.Status, as in grpc-status-details-bin; may be empty.
  Error(grpc::StatusCode code, const std::string& message, const std::string& details);

  grpc::StatusCode code() const { return code_; }
  /// All that is wrong with the request.
  const std::vector<FieldViolation>& violations() const { return violations_; }
  /// A constant in UPPER_SNAKE_CASE such as "SESSION_NOT_FOUND"; empty if the server sent none.
  const std::string& reason() const { return reason_; }
  const std::map<std::string, std::string>& metadata() const { return metadata_; }

 private:
  grpc::StatusCode code_;
  std::vector<FieldViolation> violations_;
  std::string reason_;
  std::map<std::string, std::string> metadata_;
};

}  // namespace stiefel::client
