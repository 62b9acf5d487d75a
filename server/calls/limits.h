#pragma once

#include <cstddef>
#include <cstdint>

namespace stiefel::server {

/// The page sizes of ListSessions.
inline constexpr std::size_t default_page_size = 100;
inline constexpr std::size_t max_page_size = 1000;

/// The most members with which it takes at most a slice of work to resolve or convert an ensemble,
/// or to make its simulation, which takes 10 µs a member.
inline constexpr std::uint32_t few_members = 64;

}  // namespace stiefel::server
