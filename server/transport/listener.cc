#include "server/transport/listener.h"

#include "server/address.h"
#include "server/transport/tcp_listener.h"
#include "server/transport/unix_listener.h"

namespace stiefel::server {

std::vector<Listener> listen_on(const std::string& address) {
  if (!is_unix(address)) return listen_on_tcp(address);
  std::vector<Listener> one;
  one.push_back(listen_on_unix(address));
  return one;
}

std::optional<std::string> listen_fault(const std::string& address) {
  return is_unix(address) ? unix_fault(address) : tcp_fault(address);
}

}  // namespace stiefel::server
