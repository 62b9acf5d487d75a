#include "client/cpp/channel.h"

#include <arpa/inet.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>

#include "stiefel/client/error.h"

namespace stiefel::client {
namespace {

using Credentials = std::shared_ptr<grpc::ChannelCredentials>;

[[noreturn]] void refuse(const std::string& fault) {
  throw Error(grpc::StatusCode::INVALID_ARGUMENT, fault);
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

std::string token_of(const Security& security) {
  const char* const variable = std::getenv("STIEFEL_TOKEN");
  std::string token = !security.token.empty() ? security.token : variable ? variable : "";
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

Credentials credentials(const std::string& address, const Security& security,
                        grpc::ChannelArguments& arguments) {
  const std::string token = token_of(security);
  if (security.tls) {
    if (is_unix(address)) refuse("tls: " + address + ": a Unix socket has no TLS");
    return with_token(tls_credentials(*security.tls, arguments), token, GRPC_PRIVACY_AND_INTEGRITY);
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

std::shared_ptr<grpc::Channel> make_channel(const std::string& address, const Security& security) {
  grpc::ChannelArguments arguments;
  // Much shorter than the patience of a call, so that the call finds a restarted server again.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 50);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 500);
  // A connection on which nothing has come for 10 s while a call runs is pinged, and given up when
  // nothing comes for 10 s more. The server takes a ping every 9 s. Pings are not held back for
  // want of data between them.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 10'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  const Credentials secured = credentials(address, security, arguments);
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
