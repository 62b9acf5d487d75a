#pragma once

#include <atomic>

namespace stiefel::server {

/// What a test does at the failpoints that calls, threads and files pass: it looks at the name and
/// may throw. Null, as in every program but the tests': nothing. The option STIEFEL_FAILPOINTS=OFF
/// compiles them away.
using FailpointHook = void (*)(const char* name);

#ifdef STIEFEL_NO_FAILPOINTS

inline void failpoint(const char*) {}

#else

inline std::atomic<FailpointHook> failpoint_hook = nullptr;

/// Stands where an allocation, a write or a library may fail by an exception, before anything there
/// has changed; never in a function that is noexcept, unless inside its try. One load of a pointer.
inline void failpoint(const char* name) {
  if (const FailpointHook hook = failpoint_hook.load(std::memory_order_relaxed)) hook(name);
}

#endif

}  // namespace stiefel::server
