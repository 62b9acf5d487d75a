#pragma once

#include <optional>
#include <string>

#include "server/transport/listener.h"

namespace stiefel::server {

/// Whether only this machine reaches it: a Unix socket, 127.0.0.0/8 or ::1.
bool is_local(const SocketAddress& address);

/// Why a server must not listen on `address` (one that address_fault accepts) without TLS: other
/// machines reach one of its IP addresses. Nothing for what only this machine reaches, and for
/// names without IP address, which listen_fault refuses.
std::optional<std::string> exposure_fault(const std::string& address);

}  // namespace stiefel::server
