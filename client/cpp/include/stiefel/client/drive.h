#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "stiefel/client/connection.h"

namespace stiefel::client {

/// Step for tight loops: one call stays open for many steps. It is opened again when it breaks
/// because the server is UNAVAILABLE. Not thread-safe.
class Drive {
 public:
  Drive(std::shared_ptr<const Connection> connection, std::string session_id,
        std::shared_ptr<Recreation> recreation = nullptr);
  ~Drive();
  Drive(Drive&&) noexcept = default;
  Drive& operator=(Drive&&) = delete;

  /// Returns the state at an absolute step. `fields` stay in force until a later call names others.
  /// A state too large for one reply is fetched over a stream. Throws Error; the drive remains
  /// usable after a wrong request.
  v1::StepResponse step(std::int64_t to, const std::vector<std::string>& fields = {});

 private:
  void open();
  void close();
  /// Sends the request and waits for the reply. If the call breaks, closes it and returns its
  /// status, which is not OK.
  grpc::Status ask(v1::DriveResponse& response);

  std::shared_ptr<const Connection> connection_;
  std::shared_ptr<Recreation> recreation_;
  std::unique_ptr<grpc::ClientContext> context_;
  std::unique_ptr<CancelOnStop> cancel_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::DriveRequest, v1::DriveResponse>> call_;
  v1::DriveRequest request_;
};

}  // namespace stiefel::client
