#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "stiefel/client/call.h"

namespace stiefel::client {

/// Step for tight loops: one call stays open for many steps. Destruction cancels it. Not
/// thread-safe.
class Drive {
 public:
  Drive(std::shared_ptr<const Connection> connection, const std::string& session_id);
  ~Drive();
  Drive(Drive&&) noexcept = default;
  /// Deleted because it would abandon the assigned-to call without cancelling it.
  Drive& operator=(Drive&&) = delete;

  /// Returns the state at an absolute step, or the last good one if the run ended before; see the
  /// reply's run status. `fields` stay in force until a later call names others. Throws Error; the
  /// drive remains usable after a wrong request, but not after the connection broke.
  v1::StepResponse step(std::int64_t to, const std::vector<std::string>& fields = {});

 private:
  std::shared_ptr<const Connection> connection_;
  std::unique_ptr<Context> context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::DriveRequest, v1::DriveResponse>> call_;
  v1::DriveRequest request_;
};

}  // namespace stiefel::client
