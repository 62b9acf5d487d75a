#include "server/connections/listener.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/file.h>
#include <sys/un.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <expected>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <thread>

namespace stiefel::server {
namespace {

constexpr std::size_t longest_path = sizeof(sockaddr_un::sun_path) - 1;
constexpr std::size_t longest_host = 253;
constexpr int largest_port = 65535;

bool is_ip(int family, std::string_view host) {
  unsigned char address[sizeof(in6_addr)];
  return inet_pton(family, std::string(host).c_str(), address) == 1;
}

/// Whether a host may be a name: letters, digits, '-', '_' and dots, and not digits alone, which
/// only IPv4 addresses have.
bool is_host_name(std::string_view host) {
  const auto letter = [](unsigned char c) { return std::isalpha(c) != 0; };
  const auto allowed = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.';
  };
  return host.size() <= longest_host && std::ranges::all_of(host, allowed) &&
         std::ranges::any_of(host, letter);
}

bool is_host(std::string_view host) {
  if (!host.starts_with('[')) return is_ip(AF_INET, host) || is_host_name(host);
  if (!host.ends_with(']')) return false;
  host = host.substr(1, host.size() - 2);
  return is_ip(AF_INET6, host.substr(0, host.find('%')));
}

bool is_port(std::string_view port) {
  int value = -1;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), value);
  return error == std::errc() && end == port.data() + port.size() && value >= 0 &&
         value <= largest_port && port.front() != '-';
}

std::optional<std::string> path_fault(std::string_view path) {
  if (path.empty()) return "must have a path after unix:";
  if (path.size() > longest_path)
    return "the path of " + std::to_string(path.size()) + " bytes must have at most " +
           std::to_string(longest_path);
  return std::nullopt;
}

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

SocketAddress address_of(const std::string& path) {
  SocketAddress address;
  auto& name = reinterpret_cast<sockaddr_un&>(address.storage);
  name.sun_family = AF_UNIX;
  std::memcpy(name.sun_path, path.c_str(), path.size() + 1);
  address.length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size() + 1);
  return address;
}

Descriptor new_socket() {
  return Descriptor(socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
}

std::filesystem::path folder_of(const std::string& path) {
  return std::filesystem::absolute(path).parent_path();
}

constexpr const char* other_file = "the path is a file and no socket";

/// Locks the folder of a socket, so that servers that start together look at the path and bind it
/// one after another. Waits at most a second, so that nobody who may read the folder can block a
/// start.
Descriptor locked_folder(const std::string& path) {
  Descriptor lock(open(folder_of(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  for (int attempt = 0; lock && attempt < 100; ++attempt) {
    if (flock(lock.get(), LOCK_EX | LOCK_NB) == 0) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return lock;
}

/// Removes the socket of a server that has ended; returns why the path cannot be bound, empty if it
/// can.
std::string make_free(const std::string& path, const SocketAddress& address) {
  struct stat found;
  if (lstat(path.c_str(), &found) != 0) return errno == ENOENT ? "" : std::strerror(errno);
  if (!S_ISSOCK(found.st_mode)) return other_file;
  const Descriptor probe = new_socket();
  if (!probe) return std::strerror(errno);
  if (::connect(probe.get(), address.get(), address.length) == 0 || errno == EAGAIN)
    return "another server listens there";
  if (errno != ECONNREFUSED && errno != ENOENT) return std::strerror(errno);
  return unlink(path.c_str()) == 0 || errno == ENOENT ? "" : std::strerror(errno);
}

Listener listen_on_unix(const std::string& address) {
  const auto refuse = [&](const std::string& why) {
    throw std::runtime_error("cannot listen on " + address + ": " + why);
  };
  const std::string path(unix_path(address));
  const SocketAddress at = address_of(path);
  const Descriptor lock = locked_folder(path);
  if (const std::string fault = make_free(path, at); !fault.empty()) refuse(fault);
  Descriptor socket = new_socket();
  // On Linux the file gets the mode that the socket has when it is bound.
  if (!socket || fchmod(socket.get(), 0600) != 0 || bind(socket.get(), at.get(), at.length) != 0)
    refuse(std::strerror(errno));
  Listener listener{std::move(socket), at, 0, SocketFile(path)};
  if (listen(listener.socket.get(), SOMAXCONN) != 0) refuse(std::strerror(errno));
  return listener;
}

}  // namespace

bool is_unix(std::string_view address) { return address.starts_with("unix:"); }

std::string_view unix_path(std::string_view address) {
  address.remove_prefix(5);
  if (address.starts_with("///")) address.remove_prefix(2);
  return address;
}

std::optional<std::string> address_fault(std::string_view address) {
  if (is_unix(address)) return path_fault(unix_path(address));
  const std::size_t colon = address.rfind(':');
  const bool in_brackets = address.find(']', std::min(colon, address.size())) != address.npos;
  if (colon == address.npos || in_brackets) return "has no port: must be host:port or unix:PATH";
  const std::string host(address.substr(0, colon)), port(address.substr(colon + 1));
  if (!is_port(port))
    return "the port '" + port + "' must be a number from 0 to " + std::to_string(largest_port);
  if (is_ip(AF_INET6, host))
    return "the host '" + host + "' is an IPv6 address and must be in brackets";
  if (!is_host(host))
    return "the host '" + host + "' must be a name, an IPv4 address or an IPv6 address in brackets";
  return std::nullopt;
}

std::vector<SocketAddress> tcp_addresses(const std::string& address) {
  std::vector<SocketAddress> addresses;
  if (const auto resolved = resolve(address))
    for (const addrinfo* one = resolved->get(); one != nullptr; one = one->ai_next)
      addresses.push_back(address_of(*one));
  return addresses;
}

SocketFile::SocketFile(std::string path) : path_(std::move(path)) {
  if (lstat(path_.c_str(), &made_) != 0) path_.clear();
}

SocketFile::SocketFile(SocketFile&& other) noexcept
    : path_(std::exchange(other.path_, {})), made_(other.made_) {}

SocketFile::~SocketFile() {
  struct stat now;
  if (path_.empty() || lstat(path_.c_str(), &now) != 0) return;
  if (now.st_dev == made_.st_dev && now.st_ino == made_.st_ino) unlink(path_.c_str());
}

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

std::vector<Listener> listen_on(const std::string& address) {
  if (!is_unix(address)) return listen_on_tcp(address);
  std::vector<Listener> one;
  one.push_back(listen_on_unix(address));
  return one;
}

}  // namespace stiefel::server
