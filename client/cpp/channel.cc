#include "client/cpp/channel.h"

#include <arpa/inet.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>

#include "stiefel/client/error.h"

namespace stiefel::client {
namespace {

/// gRPC repeats a call up to four times while the server is UNAVAILABLE, within about 4 s, and
/// after a refusal that says when to come back in the metadata `grpc-retry-pushback-ms`, which
/// refusals without a delay forbid (-1). It does so until the first reply, or its metadata, has
/// arrived. Every call is idempotent. Five attempts are the most that gRPC makes.
constexpr const char* service_config = R"({"methodConfig": [{
  "name": [{"service": "stiefel.v1.SimulationService"}],
  "retryPolicy": {
    "maxAttempts": 5, "initialBackoff": "0.1s", "maxBackoff": "2s", "backoffMultiplier": 3,
    "retryableStatusCodes": ["UNAVAILABLE", "RESOURCE_EXHAUSTED"]}}]})";
constexpr int largest_repeated_request = 256 << 20;  // bytes, kept until the reply begins

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

using Credentials = std::shared_ptr<grpc::ChannelCredentials>;

[[noreturn]] void refuse(const std::string& fault) {
  throw Error({grpc::StatusCode::INVALID_ARGUMENT, fault});
}

bool is_unix(const std::string& address) { return address.starts_with("unix:"); }

std::string read_file(const std::string& what, const std::string& path) {
  if (path.empty()) return {};
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(file)), {});
  if (!file.is_open() || file.bad())
    refuse(what + ": " + path + ": " + (errno ? std::strerror(errno) : "cannot be read"));
  return text;
}

std::string token_of(const Options& options) {
  const char* const variable = std::getenv("STIEFEL_TOKEN");
  std::string token = !options.token.empty() ? options.token : variable ? variable : "";
  // The error does not show the token.
  if (!std::ranges::all_of(token, [](char c) { return c > ' ' && c < 0x7F; }))
    refuse("token: it must be printable ASCII without spaces");
  return token;
}

/// Sends the token with every call. gRPC's own AccessTokenCredentials would require TLS always.
class Bearer final : public grpc::MetadataCredentialsPlugin {
 public:
  explicit Bearer(std::string token) : value_("Bearer " + std::move(token)) {}

  bool IsBlocking() const override { return false; }
  grpc::Status GetMetadata(grpc::string_ref, grpc::string_ref, const grpc::AuthContext&,
                           std::multimap<grpc::string, grpc::string>* metadata) override {
    metadata->emplace("authorization", value_);
    return grpc::Status::OK;
  }

 private:
  const std::string value_;
};

Credentials with_token(const Credentials& channel, const std::string& token,
                       grpc_security_level least) {
  if (token.empty()) return channel;
  return grpc::CompositeChannelCredentials(
      channel,
      grpc::experimental::MetadataCredentialsFromPlugin(std::make_unique<Bearer>(token), least));
}

/// Whether an address is of this machine.
bool is_local(const std::string& address) {
  if (is_unix(address)) return true;
  std::string host = address.substr(0, address.rfind(':'));
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  in_addr ip4;
  in6_addr ip6;
  if (inet_pton(AF_INET, host.c_str(), &ip4) == 1) return ntohl(ip4.s_addr) >> 24 == 127;
  if (inet_pton(AF_INET6, host.c_str(), &ip6) == 1) return IN6_IS_ADDR_LOOPBACK(&ip6);
  return host == "localhost";
}

Credentials tls_credentials(const Tls& tls, grpc::ChannelArguments& arguments) {
  if (tls.certificate.empty() != tls.key.empty())
    refuse("tls: certificate and key: one needs the other");
  if (!tls.name.empty()) arguments.SetSslTargetNameOverride(tls.name);
  const std::string authorities = read_file("tls: ca", tls.ca);
  if (!tls.ca.empty() && !authorities.contains("CERTIFICATE-----"))
    refuse("tls: ca: " + tls.ca + ": must hold certificates in PEM");
  return grpc::SslCredentials({authorities, read_file("tls: key", tls.key),
                               read_file("tls: certificate", tls.certificate)});
}

Credentials credentials(const std::string& address, const Options& options,
                        grpc::ChannelArguments& arguments) {
  const std::string token = token_of(options);
  if (options.tls) {
    if (is_unix(address)) refuse("tls: " + address + ": a Unix socket has no TLS");
    return with_token(tls_credentials(*options.tls, arguments), token, GRPC_PRIVACY_AND_INTEGRITY);
  }
  if (token.empty()) return grpc::InsecureChannelCredentials();
  if (!is_local(address))
    refuse("a token is sent over TLS, to this machine or over a Unix socket only, and " + address +
           " is none of these");
  // These credentials check the connection, too: a name that resolves to another machine gets no
  // token.
  return with_token(grpc::experimental::LocalCredentials(is_unix(address) ? UDS : LOCAL_TCP), token,
                    GRPC_SECURITY_NONE);
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

std::shared_ptr<grpc::Channel> make_channel(const std::string& address, const Options& options) {
  if (const auto fault = fault_of_address(address))
    refuse("cannot reach " + address + ": " + *fault);
  grpc::ChannelArguments arguments;
  arguments.SetServiceConfigJSON(service_config);
  arguments.SetInt(GRPC_ARG_PER_RPC_RETRY_BUFFER_SIZE, largest_repeated_request);
  arguments.SetMaxReceiveMessageSize(-1);
  // Shorter than the pauses between attempts, which then find a restarted server.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 50);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 500);
  // A connection on which nothing has come for 10 s while a call runs is pinged, and given up when
  // nothing comes for 10 s more. The server takes a ping every 9 s. Pings are not held back for
  // want of data between them.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 10'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  const Credentials secured = credentials(address, options, arguments);
  return grpc::CreateCustomChannel(address, secured, arguments);
}

std::string read_token(const std::string& path) {
  const std::string text = read_file("token", path);
  constexpr const char* space = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(space);
  if (begin == text.npos) refuse("token: " + path + ": it is empty");
  return text.substr(begin, text.find_first_of(space, begin) - begin);
}

}  // namespace stiefel::client
