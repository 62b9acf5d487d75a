#pragma once

namespace stiefel::server {

/// Puts the calling thread below those that serve connections, which have the nice value of the
/// process: the worker kept for short calls 1 below, the others 5 and SCHED_BATCH, with which they
/// are not woken in place of one that runs. What the system refuses is left as it is.
void lower_priority(bool kept) noexcept;

}  // namespace stiefel::server
