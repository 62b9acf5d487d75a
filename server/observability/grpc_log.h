#pragma once

#include "server/observability/log.h"

namespace stiefel::server {

/// Sends the lines that gRPC itself logs, in the whole process, to a log while the object lives: at
/// most ten a second, with the message "grpc". A caller can cause such lines, and gRPC's own
/// writing would wait for the reader of stderr with the threads that serve connections. A process
/// has one.
class GrpcLog {
 public:
  /// The log must outlive this object.
  explicit GrpcLog(const Log& log);
  ~GrpcLog();
  GrpcLog(const GrpcLog&) = delete;
  GrpcLog& operator=(const GrpcLog&) = delete;
};

}  // namespace stiefel::server
