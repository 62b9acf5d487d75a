#pragma once

#include "server/transport/listener.h"

namespace stiefel::server {

/// listen_on and listen_fault for host:port.
std::vector<Listener> listen_on_tcp(const std::string& address);
std::optional<std::string> tcp_fault(const std::string& address);

/// Returns the IP addresses of host:port; none if the host has none.
std::vector<SocketAddress> tcp_addresses(const std::string& address);

}  // namespace stiefel::server
