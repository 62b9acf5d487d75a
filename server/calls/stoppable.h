#pragma once

#include <expected>
#include <stop_token>
#include <type_traits>
#include <utility>

#include "server/calls/host.h"
#include "server/convert/errors.h"
#include "stiefel/stop.h"

namespace stiefel::server {

/// The error of a call that was told to stop: CANCELLED where its caller went away, SHUTTING_DOWN
/// where the server stops.
inline grpc::Status stopped(const Lifecycle& lifecycle) {
  return lifecycle.stopping() ? errors::shutting_down() : errors::cancelled();
}

/// What `work()` computes in the engine is stopped when the token requests it.
template <class Work>
std::expected<std::invoke_result_t<Work>, grpc::Status> stoppable(const Lifecycle& lifecycle,
                                                                  const std::stop_token& stop,
                                                                  Work&& work) {
  try {
    const StopScope scope(stop);
    return std::forward<Work>(work)();
  } catch (const Stopped&) {
    return std::unexpected(stopped(lifecycle));
  }
}

}  // namespace stiefel::server
