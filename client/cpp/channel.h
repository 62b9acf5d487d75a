#pragma once

#include <grpcpp/channel.h>

#include <memory>
#include <string>

#include "stiefel/client/security.h"

namespace stiefel::client {

/// A channel to an address that `fault_of_address` accepts. Throws Error of the code
/// INVALID_ARGUMENT for a token that would travel in plaintext beyond this machine, for TLS on a
/// Unix socket, and for files that cannot be read.
std::shared_ptr<grpc::Channel> make_channel(const std::string& address, const Security& security);

/// Whether only this machine is on the way to `address`: a Unix socket, localhost, 127.0.0.0/8,
/// ::1.
bool is_local(const std::string& address);

}  // namespace stiefel::client
