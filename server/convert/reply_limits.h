#pragma once

#include <cstddef>

namespace stiefel::server {

/// Bytes of the arrays in a reply: with all else below the 4 MiB that clients accept by default.
inline constexpr std::size_t max_reply_bytes = std::size_t{2} << 20;
/// Bytes of the arrays in a message that has a part of something larger.
inline constexpr std::size_t part_bytes = std::size_t{1} << 20;

}  // namespace stiefel::server
