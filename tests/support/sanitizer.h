#pragma once

namespace stiefel::testing {

/// Whether the address or the thread sanitizer is in this program. Each takes memory of its own,
/// and a multiple of the time.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool sanitized = true;
#else
constexpr bool sanitized = false;
#endif

}  // namespace stiefel::testing
