#pragma once

#include <cstddef>

namespace stiefel::server {

/// Returns how many descriptors this process may open.
std::size_t descriptor_limit();

/// Raises the process's soft limit of descriptors (RLIMIT_NOFILE) to the hard one.
void raise_descriptor_limit();

/// The descriptors that a process needs beside its connections: listeners, epoll sets, event
/// descriptors of gRPC's threads, logs, and connections being refused.
inline constexpr std::size_t reserved_descriptors = 96;

/// Returns the most connections at once: `asked` (0: as many as possible), or what the limit of
/// descriptors leaves if that is less; at least 1.
std::size_t possible_connections(std::size_t asked);

}  // namespace stiefel::server
