#pragma once

namespace stiefel::server {

/// Lowers the calling thread's priority below that of the threads that serve connections, which
/// have the process's nice value: by 1 for the worker kept for short calls (`kept`), by 5 for the
/// others. The others also get SCHED_BATCH, with which a thread that wakes does not preempt a
/// running one. Ignores what the system refuses.
void lower_priority(bool kept) noexcept;

}  // namespace stiefel::server
