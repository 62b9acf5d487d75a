#pragma once

#include <optional>
#include <string>

namespace stiefel::server {

/// Gives every thread that starts after this call a stack of at least 8 MiB, whatever `ulimit -s`
/// is: twice Eigen's largest array on the stack (EIGEN_STACK_ALLOCATION_LIMIT).
void enlarge_thread_stacks();

/// The threads of a server beside those that compute at once: relief workers, those of gRPC, the
/// store, the log, the metrics and the listeners.
inline constexpr int other_threads = 30;

/// Starts that many threads at once and ends them. Returns why the system does not give them, with
/// the limits of the process.
std::optional<std::string> thread_fault(int count);

}  // namespace stiefel::server
