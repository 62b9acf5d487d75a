#include "stiefel/client/unreachable.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <cstdlib>

namespace stiefel::client {
namespace {

constexpr std::size_t longest_socket_path = 107;  // sun_path's 108 with the final 0
constexpr std::array other_schemes = {
    "unix-abstract:", "dns:", "ipv4:", "ipv6:", "vsock:", "xds:", "passthrough:", "google-c2p:"};

std::optional<std::string> fault_of_port(std::string_view port) {
  if (port.empty()) return "the port is missing";
  unsigned number = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  if (end != port.data() + port.size() || error == std::errc::invalid_argument)
    return "the port '" + std::string(port) + "' is not a number";
  if (error != std::errc() || number < 1 || number > 65535)
    return "the port " + std::string(port) + " is not between 1 and 65535";
  return std::nullopt;
}

struct Reason {
  std::string_view grpc;  ///< a part of gRPC's message
  std::string_view plain;
};

// The first match counts; so reasons for one address stand before those for the whole name.
constexpr std::array reasons = {
    Reason{"Connection refused", "the connection is refused, nothing listens there"},
    Reason{"No such file or directory", "there is no such socket"},
    Reason{"Permission denied", "permission is denied"},
    Reason{"No route to host", "there is no route to this host"},
    Reason{"Network is unreachable", "its network cannot be reached"},
    Reason{"Connection reset", "the connection broke"},
    Reason{"Broken pipe", "the connection broke"},
    Reason{"Socket closed", "the connection broke"},
    Reason{"Received RST_STREAM", "the connection broke"},
    Reason{"Stream removed", "the connection broke"},
    Reason{"is not in peer certificate", "its certificate has another name"},
    Reason{"CERTIFICATE_VERIFY_FAILED", "its certificate is not trusted"},
    Reason{"certificate verify failed", "its certificate is not trusted"},
    Reason{"wrong version number", "it does not speak TLS"},
    Reason{"WRONG_VERSION_NUMBER", "it does not speak TLS"},
    Reason{"Ssl handshake failed", "the TLS handshake failed"},
    Reason{"handshaker shutdown", "nothing that speaks gRPC answers there"},
    Reason{"http1.x server", "nothing that speaks gRPC answers there"},
    Reason{"Failed parsing HTTP/2", "nothing that speaks gRPC answers there"},
    Reason{"Timeout occurred", "the server does not answer"},
    Reason{"timed out", "the server does not answer"},
    Reason{"Could not contact DNS servers", "no name server answers"},
    Reason{"Timeout while contacting DNS servers", "no name server answers"},
    Reason{"DNS server returned general failure", "the name server fails"},
    Reason{"DNS resolution failed", "the name is unknown"},
    Reason{"Name or service not known", "the name is unknown"},
};

constexpr std::string_view enhance_your_calm = "Received RST_STREAM with error code 11";

// What gRPC says of a call that a server or a proxy answered without details of ours.
constexpr std::array answers = {
    Reason{
        enhance_your_calm,
        "the server or a proxy before it refuses the call as too much: the call's metadata, such "
        "as its token, is too large, or too many calls or bytes come at once"},
    Reason{"received initial metadata size exceeds",
           "the call's metadata, such as its token, is larger than the server takes"},
    Reason{"Received http2 header with status:",
           "a web server answers there, not a stiefel server"},
    Reason{"Deadline Exceeded", "the call took longer than its timeout"},
};

constexpr std::array closings = {"Socket closed", "Connection reset", "Broken pipe"};

/// Whether a server accepted the connection and closed it before anything came.
bool is_closed_at_once(const std::string& message) {
  return message.starts_with("failed to connect") &&
         std::ranges::any_of(closings, [&](const char* part) { return message.contains(part); });
}

/// Returns the REASON of a message such as "failed to connect to all addresses; last error:
/// UNKNOWN: ipv4:10.0.0.1:50551: REASON".
std::string innermost(const std::string& message) {
  const std::size_t last = message.rfind(": ");
  return last == std::string::npos || last + 2 == message.size() ? message
                                                                 : message.substr(last + 2);
}

}  // namespace

std::optional<std::string> fault_of_address(std::string_view address) {
  if (address.empty()) return "the address is empty";
  if (address.starts_with("unix:")) {
    const std::string_view path = address.substr(address.starts_with("unix://") ? 7 : 5);
    if (path.empty()) return "the socket's path is missing";
    if (path.size() > longest_socket_path)
      return "the socket's path is longer than " + std::to_string(longest_socket_path) + " bytes";
    return std::nullopt;
  }
  if (std::ranges::any_of(other_schemes, [&](auto scheme) { return address.starts_with(scheme); }))
    return std::nullopt;
  if (address.find("://") != std::string_view::npos)
    return "it must be HOST:PORT, without '" +
           std::string(address.substr(0, address.find("://") + 3)) + "'";
  if (address.find_first_of(" \t\r\n/") != std::string_view::npos)
    return "it must be HOST:PORT or unix:PATH";
  if (address.front() == '[') {
    const std::size_t close = address.find(']');
    if (close == std::string_view::npos || close == 1) return "it must be [IPv6]:PORT";
    if (close + 1 == address.size()) return "the port is missing";
    if (address[close + 1] != ':') return "it must be [IPv6]:PORT";
    return fault_of_port(address.substr(close + 2));
  }
  const std::size_t colon = address.find(':');
  if (colon == std::string_view::npos) return "the port is missing";
  if (address.find(':', colon + 1) != std::string_view::npos)
    return "an IPv6 address is written in brackets, [IPv6]:PORT";
  if (colon == 0) return "the host is missing";
  return fault_of_port(address.substr(colon + 1));
}

grpc::Status as_unavailable(const grpc::Status& status) {
  const auto code = status.error_code();
  const bool may_be = code == grpc::StatusCode::CANCELLED || code == grpc::StatusCode::INTERNAL ||
                      code == grpc::StatusCode::UNKNOWN;
  if (!may_be || !status.error_details().empty()) return status;
  const std::string& message = status.error_message();
  const bool broke = message.starts_with("Received RST_STREAM") || message == "Stream removed" ||
                     message == "Socket closed" || message == "CANCELLED" ||
                     message == "No status received";
  return broke ? grpc::Status(grpc::StatusCode::UNAVAILABLE, message) : status;
}

bool is_too_much_at_once(const grpc::Status& status) {
  return status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED &&
         status.error_details().empty() && status.error_message().starts_with(enhance_your_calm);
}

bool is_unreadable(const grpc::Status& status) {
  return status.error_code() == grpc::StatusCode::UNIMPLEMENTED &&
         status.error_message() == "No message returned for unary request";
}

grpc::Status in_plain_words(const grpc::Status& status, const std::string& address, bool connected,
                            bool tls) {
  if (!status.error_details().empty()) return status;
  const std::string cannot = "cannot reach " + address + ": ";
  const bool late = status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED;
  if (late && !connected && !address.empty())
    return {status.error_code(), cannot + "the server does not answer"};
  const std::string& message = status.error_message();
  const auto answer =
      std::ranges::find_if(answers, [&](const Reason& r) { return message.starts_with(r.grpc); });
  if (answer != answers.end()) return {status.error_code(), std::string(answer->plain)};
  if (address.empty() || status.error_code() != grpc::StatusCode::UNAVAILABLE) return status;
  if (is_closed_at_once(message))
    return {status.error_code(), cannot + "it closes the connection, as a server " +
                                     (tls ? "does that asks clients for a certificate"
                                          : "with TLS does to a client without")};
  const auto found = std::ranges::find_if(
      reasons, [&](const Reason& r) { return message.find(r.grpc) != std::string::npos; });
  return {status.error_code(),
          cannot + (found != reasons.end() ? std::string(found->plain) : innermost(message))};
}

grpc::Status with_price(const grpc::Status& status, const grpc::ClientContext& context) {
  constexpr double work_per_second = 5e9;  // instructions of one core
  if (status.error_code() != grpc::StatusCode::DEADLINE_EXCEEDED) return status;
  const auto& metadata = context.GetServerInitialMetadata();
  const auto told = metadata.find("stiefel-work");
  if (told == metadata.end()) return status;
  const std::string work(told->second.data(), told->second.size());
  char seconds[32];
  std::snprintf(seconds, sizeof seconds, "%.2g",
                std::strtod(work.c_str(), nullptr) / work_per_second);
  const bool capped = metadata.contains("stiefel-work-bound");
  return {status.error_code(), status.error_message() + "; it takes " +
                                   (capped ? "at most " : "about ") + seconds + " s of one core (" +
                                   work + " instructions)"};
}

}  // namespace stiefel::client
