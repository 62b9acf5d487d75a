#pragma once

#include "server/calls/host.h"
#include "server/convert/errors.h"

namespace stiefel::server {

/// Returns the error of a call that was stopped: SHUTTING_DOWN if the server stops, otherwise
/// CANCELLED, because its caller went away.
inline grpc::Status stopped(const Lifecycle& lifecycle) {
  return lifecycle.stopping() ? errors::shutting_down() : errors::cancelled();
}

}  // namespace stiefel::server
