#include "server/connections/listener.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <stdexcept>

namespace stiefel::server {
namespace {

constexpr std::size_t longest_path = sizeof(sockaddr_un::sun_path) - 1;
constexpr int largest_port = 65535;
/// A connection ends when its peer leaves data unacknowledged for this long.
constexpr int user_timeout_milliseconds = 20'000;

[[noreturn]] void cannot_listen(const std::string& address, const std::string& why) {
  throw std::runtime_error("cannot listen on " + address + ": " + why);
}

/// Returns PATH of unix:PATH or unix:///PATH.
std::string_view unix_path(std::string_view address) {
  address.remove_prefix(5);
  if (address.starts_with("///")) address.remove_prefix(2);
  return address;
}

std::optional<std::string> path_fault(std::string_view path) {
  if (path.empty()) return "must have a path after unix:";
  if (path.size() > longest_path)
    return "the path of " + std::to_string(path.size()) + " bytes must have at most " +
           std::to_string(longest_path);
  return std::nullopt;
}

bool is_port(std::string_view port) {
  int value = -1;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), value);
  return error == std::errc() && end == port.data() + port.size() && port.front() != '-' &&
         value <= largest_port;
}

bool may_be_host(std::string_view host) {
  if (host.starts_with('[')) return host.ends_with(']');
  return !host.empty() && host.find(':') == host.npos;
}

/// The IP addresses of a host.
struct Resolved {
  explicit Resolved(const std::string& address) {
    const std::size_t colon = address.rfind(':');
    std::string host = address.substr(0, colon);
    if (host.starts_with('[')) host = host.substr(1, host.size() - 2);
    addrinfo hints{};
    hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
    hints.ai_socktype = SOCK_STREAM;
    fault = getaddrinfo(host.c_str(), address.c_str() + colon + 1, &hints, &first);
  }
  ~Resolved() {
    if (first != nullptr) freeaddrinfo(first);
  }
  Resolved(const Resolved&) = delete;
  Resolved& operator=(const Resolved&) = delete;

  addrinfo* first = nullptr;
  int fault = 0;
};

bool is_loopback(const sockaddr& address) {
  if (address.sa_family == AF_INET)
    return ntohl(reinterpret_cast<const sockaddr_in&>(address).sin_addr.s_addr) >> 24 == 127;
  const in6_addr& ip = reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
  return IN6_IS_ADDR_LOOPBACK(&ip) || (IN6_IS_ADDR_V4MAPPED(&ip) && ip.s6_addr[12] == 127);
}

in_port_t& port_of(sockaddr& address) {
  return address.sa_family == AF_INET6 ? reinterpret_cast<sockaddr_in6&>(address).sin6_port
                                       : reinterpret_cast<sockaddr_in&>(address).sin_port;
}

/// Listens on one IP address, whose port becomes that of the socket. Returns nothing, with the
/// reason in errno, if the system refuses.
std::optional<Listener> listening(const addrinfo& at) {
  const auto set = [](const Descriptor& socket, int level, int option, int value) {
    setsockopt(socket.get(), level, option, &value, sizeof value);
  };
  Descriptor socket(::socket(at.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket) return std::nullopt;
  set(socket, SOL_SOCKET, SO_REUSEADDR, 1);
  set(socket, IPPROTO_TCP, TCP_NODELAY, 1);
  set(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, user_timeout_milliseconds);
  if (at.ai_family == AF_INET6) set(socket, IPPROTO_IPV6, IPV6_V6ONLY, 0);
  socklen_t length = at.ai_addrlen;
  if (bind(socket.get(), at.ai_addr, length) != 0 || listen(socket.get(), SOMAXCONN) != 0 ||
      getsockname(socket.get(), at.ai_addr, &length) != 0)
    return std::nullopt;
  return Listener{std::move(socket), ntohs(port_of(*at.ai_addr))};
}

std::vector<Listener> listen_on_tcp(const std::string& address) {
  const Resolved resolved(address);
  if (resolved.fault != 0) cannot_listen(address, gai_strerror(resolved.fault));
  std::vector<Listener> listeners;
  int fault = 0;
  for (const addrinfo* one = resolved.first; one != nullptr; one = one->ai_next) {
    // All IP addresses of a name get the port of the first one.
    if (!listeners.empty())
      port_of(*one->ai_addr) = htons(static_cast<in_port_t>(listeners.front().port));
    if (auto listener = listening(*one))
      listeners.push_back(*std::move(listener));
    else if (fault == 0)
      fault = errno;
  }
  if (listeners.empty()) cannot_listen(address, std::strerror(fault));
  return listeners;
}

Descriptor unix_socket() {
  return Descriptor(socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
}

/// Removes the socket of a server that has ended; returns why the path cannot be bound, empty if it
/// can.
std::string make_free(const char* path, const sockaddr& at, socklen_t length) {
  struct stat found;
  if (lstat(path, &found) != 0) return errno == ENOENT ? "" : std::strerror(errno);
  if (!S_ISSOCK(found.st_mode)) return "the path is a file and no socket";
  const Descriptor probe = unix_socket();
  if (!probe) return std::strerror(errno);
  if (::connect(probe.get(), &at, length) == 0 || errno == EAGAIN)
    return "another server listens there";
  if (errno != ECONNREFUSED && errno != ENOENT) return std::strerror(errno);
  return unlink(path) == 0 || errno == ENOENT ? "" : std::strerror(errno);
}

std::shared_ptr<void> removed_in_the_end(const std::string& path) {
  struct stat made;
  if (lstat(path.c_str(), &made) != 0) return nullptr;
  return {nullptr, [path, made](void*) {
            struct stat now;
            if (lstat(path.c_str(), &now) == 0 && now.st_dev == made.st_dev &&
                now.st_ino == made.st_ino)
              unlink(path.c_str());
          }};
}

Listener listen_on_unix(const std::string& address) {
  const std::string path(unix_path(address));
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  std::memcpy(name.sun_path, path.c_str(), path.size() + 1);
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size() + 1);
  const auto& at = reinterpret_cast<const sockaddr&>(name);
  if (const std::string fault = make_free(path.c_str(), at, length); !fault.empty())
    cannot_listen(address, fault);
  Descriptor socket = unix_socket();
  // On Linux the file gets the mode that the socket has when it is bound.
  if (!socket || fchmod(socket.get(), 0600) != 0 || bind(socket.get(), &at, length) != 0)
    cannot_listen(address, std::strerror(errno));
  Listener listener{std::move(socket), 0, removed_in_the_end(path)};
  if (listen(listener.socket.get(), SOMAXCONN) != 0) cannot_listen(address, std::strerror(errno));
  return listener;
}

}  // namespace

bool is_unix(std::string_view address) { return address.starts_with("unix:"); }

std::optional<std::string> address_fault(std::string_view address) {
  if (is_unix(address)) return path_fault(unix_path(address));
  const std::size_t colon = address.rfind(':');
  if (colon == address.npos || address.find(']', colon) != address.npos)
    return "has no port: must be host:port or unix:PATH";
  const std::string host(address.substr(0, colon)), port(address.substr(colon + 1));
  if (!is_port(port))
    return "the port '" + port + "' must be a number from 0 to " + std::to_string(largest_port);
  if (!may_be_host(host))
    return "the host '" + host + "' must be a name, an IPv4 address or an IPv6 address in brackets";
  return std::nullopt;
}

bool is_exposed(const std::string& address) {
  if (is_unix(address)) return false;
  const Resolved resolved(address);
  for (const addrinfo* one = resolved.first; one != nullptr; one = one->ai_next)
    if (!is_loopback(*one->ai_addr)) return true;
  return false;
}

std::vector<Listener> listen_on(const std::string& address) {
  if (!is_unix(address)) return listen_on_tcp(address);
  std::vector<Listener> one;
  one.push_back(listen_on_unix(address));
  return one;
}

}  // namespace stiefel::server
