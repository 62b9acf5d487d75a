#pragma once

#include <optional>
#include <string>

#include "server/transport/listener.h"

namespace stiefel::server {

/// Whether only this machine can reach the address: a Unix socket, 127.0.0.0/8 or ::1.
bool is_local(const SocketAddress& address);

/// Returns why a server must not listen on `address` (one that address_fault accepts) without TLS:
/// other machines can reach one of its IP addresses. Returns nothing for an address that only this
/// machine can reach, and for a name without an IP address, which listen_fault refuses.
std::optional<std::string> exposure_fault(const std::string& address);

}  // namespace stiefel::server
