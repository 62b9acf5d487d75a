#pragma once

#include "server/server.h"

namespace stiefel::server {

/// Returns how many threads a server with these options starts at most at once, without those that
/// gRPC adds under load.
int threads_of(const Options& options);

/// Checks whether a server could start with these options: addresses, files of certificates, tokens
/// and keys, the store, the limits of threads and descriptors. Writes each fault with its flag as a line on
/// stderr. Returns the exit status, 0 if there is no fault. Does not disturb a running server.
int check(const Options& options);

}  // namespace stiefel::server
