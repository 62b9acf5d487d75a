#pragma once

namespace stiefel::testing {

/// Whether this program runs with the address or the thread sanitizer, which need additional memory
/// and a multiple of the time.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool sanitized = true;
#else
constexpr bool sanitized = false;
#endif

}  // namespace stiefel::testing
