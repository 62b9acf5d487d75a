#pragma once

#include "server/server.h"

namespace stiefel::server {

/// Exit status 0 if a server could start with these options: addresses, files of certificates,
/// tokens and keys, the limit of descriptors. Each fault is a line on stderr with its flag. A
/// server that runs is left alone.
int check(const Options& options);

}  // namespace stiefel::server
