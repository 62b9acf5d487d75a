#pragma once

#include <grpcpp/channel.h>

#include <memory>
#include <string>

#include "stiefel/client/security.h"

namespace stiefel::client {

/// Returns a channel to an address in which `fault_of_address` finds no fault. Throws Error with
/// the code INVALID_ARGUMENT for a token that would travel in plaintext beyond this machine, for
/// TLS on a Unix socket, and for files that cannot be read.
std::shared_ptr<grpc::Channel> make_channel(const std::string& address, const Security& security);

/// Returns whether the address is on this machine: a Unix socket, localhost, 127.0.0.0/8 or ::1.
bool is_local(const std::string& address);

}  // namespace stiefel::client
