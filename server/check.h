#pragma once

#include "server/server.h"

namespace stiefel::server {

/// Checks whether a server could start with these options: addresses, files of certificates, tokens
/// and keys, the store, the limit of descriptors. Writes each fault with its flag as a line on
/// stderr. Returns the exit status, 0 if there is no fault. Does not disturb a running server.
int check(const Options& options);

}  // namespace stiefel::server
