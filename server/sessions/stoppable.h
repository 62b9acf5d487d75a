#pragma once

#include <optional>
#include <stop_token>
#include <type_traits>
#include <utility>

#include "stiefel/stop.h"

namespace stiefel::server {

/// Returns what `work()` computes in the engine, or nothing when `stop` is requested before it
/// ends.
template <class Work>
std::optional<std::invoke_result_t<Work>> stoppable(const std::stop_token& stop, Work&& work) {
  return unless_stopped(stop, std::forward<Work>(work));
}

}  // namespace stiefel::server
