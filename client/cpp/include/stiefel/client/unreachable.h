#pragma once

#include <grpcpp/support/status.h>

#include <optional>
#include <string>
#include <string_view>

namespace stiefel::client {

/// The fault of an address, such as "the port 99999 is not between 1 and 65535"; nothing for
/// HOST:PORT, [IPv6]:PORT, unix:PATH, and what has another scheme of gRPC's ("dns:", "ipv4:", ...),
/// which are gRPC's to check.
std::optional<std::string> fault_of_address(std::string_view address);

/// UNAVAILABLE for a call whose connection broke while it ran, such as that of a proxy to its
/// server, and for one that reached a server at its end: gRPC reports them as CANCELLED, INTERNAL
/// or UNKNOWN. Any other status as it is. Not for calls that this side has cancelled.
grpc::Status as_unavailable(const grpc::Status& status);

/// "cannot reach HOST:PORT: the connection is refused", in place of what gRPC says of a call that
/// found no server; any other status as it is. What a server itself says has details and stays.
/// `connected`: whether the channel was when the call failed; a deadline that passes without a
/// connection means that the server does not answer.
grpc::Status in_plain_words(const grpc::Status& status, const std::string& address, bool connected);

}  // namespace stiefel::client
