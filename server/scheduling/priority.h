#pragma once

namespace stiefel::server {

/// Puts the calling thread below those that serve connections, which have nice 0: the worker kept
/// for short calls a little (nice 1), the others further (nice 5, SCHED_BATCH: they are not woken
/// in place of one that runs). What the system refuses is left as it is.
void lower_priority(bool kept) noexcept;

}  // namespace stiefel::server
