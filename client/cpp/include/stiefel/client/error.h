#pragma once

#include <grpcpp/support/status.h>

#include <chrono>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace stiefel::v1 {
class Status;
}

namespace stiefel::client {

/// A field of a request that breaks a rule, or a limit of the server that a request exceeds.
struct Violation {
  std::string field;  ///< the field's path, "scene.initial.Q", or the limit's name, "sessions"
  std::string description;  ///< the value and the rule
};

/// A call that failed: a wrong request, a refusal, or a server that cannot be reached. Numerical
/// stops are not errors; they are the `run_status` of a reply. The code is DATA_LOSS for a reply
/// whose arrays are incomplete.
class Error : public std::runtime_error {
 public:
  explicit Error(const grpc::Status& status);
  /// `status`: the error in a reply of Drive.
  explicit Error(const v1::Status& status);

  grpc::StatusCode code() const { return code_; }
  /// All fields of the request that break a rule; with RESOURCE_EXHAUSTED, all limits that it
  /// exceeds.
  const std::vector<Violation>& violations() const { return violations_; }
  /// The least time after which the same request may succeed, if the server sent one.
  std::optional<std::chrono::nanoseconds> retry_delay() const { return retry_delay_; }
  /// A constant in UPPER_SNAKE_CASE such as "SESSION_NOT_FOUND"; empty if the server sent none.
  const std::string& reason() const { return reason_; }
  const std::map<std::string, std::string>& metadata() const { return metadata_; }

 private:
  void read(const v1::Status& status);

  grpc::StatusCode code_;
  std::vector<Violation> violations_;
  std::optional<std::chrono::nanoseconds> retry_delay_;
  std::string reason_;
  std::map<std::string, std::string> metadata_;
};

}  // namespace stiefel::client
