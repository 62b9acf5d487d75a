#pragma once

#include <cstddef>

namespace stiefel::server {

/// The most bytes of arrays in a reply, which keep it below the 4 MiB that clients accept by
/// default.
inline constexpr std::size_t max_reply_bytes = std::size_t{2} << 20;
/// The most bytes of arrays in a message that carries a part of something larger.
inline constexpr std::size_t part_bytes = std::size_t{1} << 20;

}  // namespace stiefel::server
