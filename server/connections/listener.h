#pragma once

#include <sys/socket.h>
#include <sys/stat.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/scheduling/process.h"

namespace stiefel::server {

/// Returns the rule that an address breaks, or nothing. An address is host:port, where the host is
/// a name, an IPv4 address or an IPv6 address in brackets and the port is 0 to 65535; or unix:PATH
/// (unix:///PATH) with a path of 1 to 107 bytes, the most that a socket's name holds.
std::optional<std::string> address_fault(std::string_view address);

bool is_unix(std::string_view address);
/// Returns PATH of unix:PATH or unix:///PATH.
std::string_view unix_path(std::string_view address);

/// The address of a socket, as the kernel stores it.
struct SocketAddress {
  sockaddr_storage storage{};
  socklen_t length = 0;

  sockaddr* get() { return reinterpret_cast<sockaddr*>(&storage); }
  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
};

/// The file of a Unix socket. The destructor removes the file that `bind` made, unless another has
/// replaced it.
class SocketFile {
 public:
  explicit SocketFile(std::string path);
  SocketFile(SocketFile&& other) noexcept;
  SocketFile& operator=(SocketFile&&) = delete;
  ~SocketFile();

 private:
  std::string path_;
  struct stat made_ {};
};

/// A non-blocking listening socket; its connections inherit its TCP options.
struct Listener {
  Descriptor socket;
  SocketAddress address;
  int port = 0;                         ///< 0 for a Unix socket
  std::optional<SocketFile> file = {};  ///< destroyed first: the name goes before the socket
};

/// Listens on an address that `address_fault` accepts: on every IP address of a host name, on IPv4
/// and IPv6 for [::]; port 0 means a free one. Only its owner can use a Unix socket (mode 0600),
/// whose file replaces that of a server that has ended. Throws std::runtime_error with the system's
/// reason, also if another server listens on the Unix socket or the path is another kind of file.
std::vector<Listener> listen_on(const std::string& address);

/// Returns the IP addresses of host:port; none if the host has none.
std::vector<SocketAddress> tcp_addresses(const std::string& address);

/// Whether only this machine can reach the address: a Unix socket, 127.0.0.0/8 or ::1.
bool is_local(const SocketAddress& address);

/// Returns why a server must not listen on `address` (one that address_fault accepts) without TLS:
/// other machines can reach one of its IP addresses. Returns nothing for an address that only this
/// machine can reach, and for a name without an IP address.
std::optional<std::string> exposure_fault(const std::string& address);

}  // namespace stiefel::server
