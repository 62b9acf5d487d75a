#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/scheduling/process.h"

namespace stiefel::server {

/// Returns the rule that an address breaks, or nothing. An address is host:port, where the host is
/// a name, an IPv4 address or an IPv6 address in brackets and the port is 0 to 65535; or unix:PATH
/// (unix:///PATH) with a path of 1 to 107 bytes, the most that a socket's name holds. Whether the
/// host exists is found out when it is used.
std::optional<std::string> address_fault(std::string_view address);

bool is_unix(std::string_view address);

/// A non-blocking listening socket; its connections inherit its TCP options.
struct Listener {
  Descriptor socket;
  int port = 0;                     ///< 0 for a Unix socket
  std::shared_ptr<void> file = {};  ///< of a Unix socket: removes its file when it is destroyed,
                                    ///< unless another file has replaced it
};

/// Listens on an address that `address_fault` accepts: on every IP address of a host name, on IPv4
/// and IPv6 for [::]; port 0 means a free one. Only its owner can use a Unix socket (mode 0600),
/// whose file replaces that of a server that has ended. Throws std::runtime_error with the system's
/// reason, also if another server listens on the Unix socket or the path is another kind of file.
std::vector<Listener> listen_on(const std::string& address);

/// Whether other machines can reach an address that `address_fault` accepts: not a Unix socket, and
/// not 127.0.0.0/8 and ::1 alone. A name without an IP address is not exposed.
bool is_exposed(const std::string& address);

}  // namespace stiefel::server
