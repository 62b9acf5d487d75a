#include "server/access/exposure.h"

#include <netinet/in.h>

#include <algorithm>

#include "server/address.h"
#include "server/transport/tcp_listener.h"

namespace stiefel::server {

bool is_local(const SocketAddress& address) {
  switch (address.storage.ss_family) {
    case AF_UNIX:
      return true;
    case AF_INET: {
      const auto& ip = reinterpret_cast<const sockaddr_in&>(address.storage).sin_addr;
      return ntohl(ip.s_addr) >> 24 == 127;
    }
    case AF_INET6: {
      const auto& ip = reinterpret_cast<const sockaddr_in6&>(address.storage).sin6_addr;
      return IN6_IS_ADDR_LOOPBACK(&ip) || (IN6_IS_ADDR_V4MAPPED(&ip) && ip.s6_addr[12] == 127);
    }
    default:
      return false;
  }
}

std::optional<std::string> exposure_fault(const std::string& address) {
  if (is_unix(address) || std::ranges::all_of(tcp_addresses(address), is_local))
    return std::nullopt;
  return "other machines can reach it: give --tls-cert and --tls-key, or --insecure";
}

}  // namespace stiefel::server
