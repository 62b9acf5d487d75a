#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace stiefel::server {

/// Returns the rule that an address breaks, or nothing. An address is host:port, where the host is
/// a name, an IPv4 address or an IPv6 address in brackets and the port is 0 to 65535; or unix:PATH
/// (unix:///PATH) with a path of 1 to 107 bytes, the most that a socket's name holds.
std::optional<std::string> address_fault(std::string_view address);

bool is_unix(std::string_view address);
/// Returns PATH of unix:PATH or unix:///PATH.
std::string_view unix_path(std::string_view address);

}  // namespace stiefel::server
