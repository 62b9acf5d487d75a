#pragma once

#include <atomic>

namespace stiefel::server {

/// A test's function, called with the name of each failpoint that a call, thread or file passes; it
/// may throw. Null, as in every program but the tests, does nothing. The option
/// STIEFEL_FAILPOINTS=OFF compiles the failpoints away.
using FailpointHook = void (*)(const char* name);

#ifdef STIEFEL_NO_FAILPOINTS

inline void failpoint(const char*) {}

#else

inline std::atomic<FailpointHook> failpoint_hook = nullptr;

/// Marks a place where an allocation, a write or a library may throw before anything has changed.
/// Never stands in a noexcept function, unless inside its try block. Costs one load of a pointer.
inline void failpoint(const char* name) {
  if (const FailpointHook hook = failpoint_hook.load(std::memory_order_relaxed)) hook(name);
}

#endif

}  // namespace stiefel::server
