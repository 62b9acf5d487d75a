#pragma once

#include <grpcpp/client_context.h>
#include <grpcpp/support/status.h>

#include <optional>
#include <string>
#include <string_view>

namespace stiefel::client {

/// Returns what is wrong with an address, such as "the port 99999 is not between 1 and 65535".
/// Returns nothing for a well-formed HOST:PORT, [IPv6]:PORT or unix:PATH, and for the other address
/// schemes of gRPC ("dns:", "ipv4:", ...), which gRPC checks.
std::optional<std::string> fault_of_address(std::string_view address);

/// Returns UNAVAILABLE for a call whose connection broke while it ran, such as the connection of a
/// proxy to its server, or that reached a server while it shut down; gRPC reports these as
/// CANCELLED, INTERNAL or UNKNOWN. Returns any other status unchanged. Do not use it for calls that
/// this side has cancelled.
grpc::Status as_unavailable(const grpc::Status& status);

/// Returns whether gRPC or a proxy ended the call because of too much at once, as HTTP/2's error
/// ENHANCE_YOUR_CALM says, so that the call may succeed later.
bool is_too_much_at_once(const grpc::Status& status);

/// Returns whether a unary call ended without a reply, or with bytes that are no message of it.
bool is_unreadable(const grpc::Status& status);

/// Replaces gRPC's message for a call that found no server by one such as "cannot reach HOST:PORT:
/// the connection is refused". Returns any other status unchanged, also one with details, which
/// comes from the server. `connected`: whether the channel was connected when the call failed; if
/// not, an expired deadline means that the server does not answer. `tls`: whether the channel has
/// TLS.
grpc::Status in_plain_words(const grpc::Status& status, const std::string& address, bool connected,
                            bool tls = false);

/// Adds to the message of a call that ended at its deadline how long it takes, where the server has
/// told that. Returns any other status unchanged.
grpc::Status with_price(const grpc::Status& status, const grpc::ClientContext& context);

}  // namespace stiefel::client
