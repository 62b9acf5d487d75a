#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace stiefel::server {

/// The rule that an address breaks, or nothing. An address is host:port, the host a name, an IPv4
/// address or an IPv6 address in brackets, the port 0 to 65535; or unix:PATH (unix:///PATH), the
/// path of 1 to 107 bytes, which is what a socket's name holds.
std::optional<std::string> address_fault(std::string_view address);

bool is_unix(std::string_view address);
/// PATH of unix:PATH or unix:///PATH.
std::string_view unix_path(std::string_view address);

}  // namespace stiefel::server
