#pragma once

#include <sys/socket.h>
#include <sys/stat.h>

#include <optional>
#include <string>
#include <vector>

#include "server/transport/descriptor.h"

namespace stiefel::server {

/// Where a socket listens, as the kernel has it.
struct SocketAddress {
  sockaddr_storage storage{};
  socklen_t length = 0;

  sockaddr* get() { return reinterpret_cast<sockaddr*>(&storage); }
  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
};

/// The file of a Unix socket. The destructor removes the file that `bind` made, and no other that
/// has taken its place since.
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

/// A socket that listens without blocking; connections inherit its TCP options.
struct Listener {
  Descriptor socket;
  SocketAddress address;
  int port = 0;                         ///< 0 for a Unix socket
  std::optional<SocketFile> file = {};  ///< destroyed first: the name goes before the socket
};

/// Listens on an address that `address_fault` accepts: on every IP address of a host name, on
/// IPv4 and IPv6 for [::]; port 0 becomes a free one. A Unix socket is for its owner only (mode
/// 0600); a file of a server that is gone is replaced. Throws std::runtime_error with the system's
/// reason, also where another server listens on the Unix socket or the path is another file.
std::vector<Listener> listen_on(const std::string& address);

/// Why `listen_on` would be refused, as far as that shows without listening: a host without IP
/// address, a folder that cannot be written, a path that is another file. A server that listens
/// there is no fault.
std::optional<std::string> listen_fault(const std::string& address);

}  // namespace stiefel::server
