#pragma once

#include <grpcpp/channel.h>

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "stiefel/client/options.h"

namespace stiefel::client {

/// Returns what is wrong with an address, such as "the port 99999 is not between 1 and 65535".
/// Returns nothing for a well-formed HOST:PORT, [IPv6]:PORT or unix:PATH, and for the other address
/// schemes of gRPC ("dns:", "ipv4:", ...), which gRPC checks.
std::optional<std::string> fault_of_address(std::string_view address);

/// Returns a channel to an address. Throws Error with the code INVALID_ARGUMENT if the address is
/// malformed, if the token would travel in plaintext beyond this machine, and if a file of TLS
/// cannot be read.
std::shared_ptr<grpc::Channel> make_channel(const std::string& address, const Options& options);

}  // namespace stiefel::client
