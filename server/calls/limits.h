#pragma once

#include <cstddef>

namespace stiefel::server {

/// The page sizes of ListSessions.
inline constexpr std::size_t default_page_size = 100;
inline constexpr std::size_t max_page_size = 1000;

}  // namespace stiefel::server
