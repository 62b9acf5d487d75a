#pragma once

#include "server/calls/host.h"
#include "server/convert/errors.h"

namespace stiefel::server {

/// The error of a call that was told to stop: CANCELLED where its caller went away, SHUTTING_DOWN
/// where the server stops.
inline grpc::Status stopped(const Lifecycle& lifecycle) {
  return lifecycle.stopping() ? errors::shutting_down() : errors::cancelled();
}

}  // namespace stiefel::server
