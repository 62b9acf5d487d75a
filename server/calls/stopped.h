#pragma once

#include "server/calls/host.h"
#include "server/convert/errors.h"

namespace stiefel::server {

/// Returns the error of a call that was stopped: SHUTTING_DOWN if the server stops, otherwise
/// CANCELLED, because its caller went away.
inline grpc::Status stopped(const Lifecycle& lifecycle) {
  return lifecycle.stopping() ? errors::shutting_down() : errors::cancelled();
}

/// Returns the status of a call for the exception being handled.
inline grpc::Status status_of_exception(const Lifecycle& lifecycle) {
  const grpc::Status status = errors::from_current_exception();
  // Of exceptions, only that of a stopped computation has this code.
  return status.error_code() == grpc::CANCELLED ? stopped(lifecycle) : status;
}

}  // namespace stiefel::server
