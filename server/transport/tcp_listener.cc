#include "server/transport/tcp_listener.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>

#include <cerrno>
#include <cstring>
#include <expected>
#include <memory>
#include <stdexcept>

namespace stiefel::server {
namespace {

/// A connection ends when its peer leaves data unacknowledged for this long.
constexpr int user_timeout_milliseconds = 20'000;

using Resolved = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

/// Returns the IP addresses of the host, or why there are none.
std::expected<Resolved, std::string> resolve(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  std::string host = address.substr(0, colon);
  if (host.starts_with('[')) host = host.substr(1, host.size() - 2);
  addrinfo hints{}, *found = nullptr;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  hints.ai_socktype = SOCK_STREAM;
  const int fault = getaddrinfo(host.c_str(), address.c_str() + colon + 1, &hints, &found);
  if (fault != 0) return std::unexpected(gai_strerror(fault));
  return Resolved(found, &freeaddrinfo);
}

in_port_t& port_of(SocketAddress& address) {
  return address.storage.ss_family == AF_INET6
             ? reinterpret_cast<sockaddr_in6&>(address.storage).sin6_port
             : reinterpret_cast<sockaddr_in&>(address.storage).sin_port;
}

void set(const Descriptor& socket, int level, int option, int value) {
  setsockopt(socket.get(), level, option, &value, sizeof value);
}

/// Returns nothing, with the reason in errno, if the system refuses.
std::optional<Listener> listening(SocketAddress at) {
  Descriptor socket(
      ::socket(at.storage.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, IPPROTO_TCP));
  if (!socket) return std::nullopt;
  set(socket, SOL_SOCKET, SO_REUSEADDR, 1);
  set(socket, IPPROTO_TCP, TCP_NODELAY, 1);
  set(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, user_timeout_milliseconds);
  if (at.storage.ss_family == AF_INET6) set(socket, IPPROTO_IPV6, IPV6_V6ONLY, 0);
  if (bind(socket.get(), at.get(), at.length) != 0 || listen(socket.get(), SOMAXCONN) != 0 ||
      getsockname(socket.get(), at.get(), &at.length) != 0)
    return std::nullopt;
  return Listener{std::move(socket), at, ntohs(port_of(at))};
}

SocketAddress address_of(const addrinfo& one) {
  SocketAddress at;
  at.length = one.ai_addrlen;
  std::memcpy(&at.storage, one.ai_addr, one.ai_addrlen);
  return at;
}

}  // namespace

std::vector<Listener> listen_on_tcp(const std::string& address) {
  const auto resolved = resolve(address);
  if (!resolved) throw std::runtime_error("cannot listen on " + address + ": " + resolved.error());
  std::vector<Listener> listeners;
  int fault = 0;
  for (const addrinfo* one = resolved->get(); one != nullptr; one = one->ai_next) {
    SocketAddress at = address_of(*one);
    // All IP addresses of a name get the port of the first one.
    if (!listeners.empty()) port_of(at) = htons(static_cast<in_port_t>(listeners.front().port));
    if (auto listener = listening(at))
      listeners.push_back(*std::move(listener));
    else if (fault == 0)
      fault = errno;
  }
  if (listeners.empty())
    throw std::runtime_error("cannot listen on " + address + ": " + std::strerror(fault));
  return listeners;
}

std::vector<SocketAddress> tcp_addresses(const std::string& address) {
  std::vector<SocketAddress> addresses;
  if (const auto resolved = resolve(address))
    for (const addrinfo* one = resolved->get(); one != nullptr; one = one->ai_next)
      addresses.push_back(address_of(*one));
  return addresses;
}

std::optional<std::string> tcp_fault(const std::string& address) {
  const auto resolved = resolve(address);
  return resolved ? std::nullopt : std::optional(resolved.error());
}

}  // namespace stiefel::server
