#pragma once

#include <cstddef>

namespace stiefel::server {

/// The largest message accepted.
inline constexpr std::size_t max_message_bytes = std::size_t{256} << 20;
/// Of ListSessions.
inline constexpr std::size_t default_page_size = 100;
inline constexpr std::size_t max_page_size = 1000;

}  // namespace stiefel::server
